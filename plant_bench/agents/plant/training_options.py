"""PlanT's training options."""

from dataclasses import dataclass, field

from plant_bench.agents.plant.config import GRAPH_BITS, GraphBits, PlanTConfig


@dataclass(frozen=True)
class PlanTOptions:
    """The training options specific to PlanT; the defaults are the paper's.

    Attributes:
        network: The network's size and inputs.
        auxiliary: Weight lambda of the auxiliary loss, the prediction of the actors' futures
            (PlanT, "Implementation").
        overshoot_weight: Loss weight of waypoints that are too far ahead, relative to those that
            are too short; 1 in PlanT.
        onnx: Also write network.onnx, which halves the inference time.
        weights_bits: Bits per weight in network.onnx: 8 is up to twice as fast, and the waypoints
            differ by about 1 cm.
    """

    network: PlanTConfig = field(default_factory=PlanTConfig)
    auxiliary: float = field(default=0.2, metadata={"min": 0.0})
    overshoot_weight: float = field(default=1.0, metadata={"min": 0.1})
    onnx: bool = False
    weights_bits: GraphBits = GRAPH_BITS
