"""What may be chosen when PlanT is trained."""

from dataclasses import dataclass, field

from plant_bench.agents.plant.config import GRAPH_BITS, GraphBits, PlanTConfig


@dataclass(frozen=True)
class PlanTOptions:
    """All that is PlanT's own in a training; the defaults are the paper's.

    Attributes:
        network: Its size and inputs.
        auxiliary: Weight of predicting the others' future, lambda (PlanT, "Implementation").
        overshoot_weight: Weight of waypoints too far ahead against those too short; 1 in PlanT.
        onnx: Write network.onnx, too: half the time a decision.
        weights_bits: Of network.onnx: 8 is up to twice as fast, waypoints differ by about a
            centimetre.
    """

    network: PlanTConfig = field(default_factory=PlanTConfig)
    auxiliary: float = field(default=0.2, metadata={"min": 0.0})
    overshoot_weight: float = field(default=1.0, metadata={"min": 0.1})
    onnx: bool = False
    weights_bits: GraphBits = GRAPH_BITS
