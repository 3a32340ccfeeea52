"""PlanT's training options."""

from dataclasses import dataclass, field
from types import MappingProxyType

from plant_bench.agents.plant.config import GRAPH_BITS, GraphBits, PlanTConfig

# Of fields whose class gives no range: a change there would change the checksum of the planner.
NETWORK_RANGES = MappingProxyType(
    {
        "reach": (1.0, 1000.0),
        "horizon": (0.0, 60.0),
        "segments": (1, 1000),
        "longest": (0.1, 1000.0),
        "tolerance": (0.0, 100.0),
    }
)


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

    network: PlanTConfig = field(default_factory=PlanTConfig, metadata={"ranges": NETWORK_RANGES})
    auxiliary: float = field(default=0.2, metadata={"min": 0.0, "max": 1e6})
    overshoot_weight: float = field(default=1.0, metadata={"min": 0.1, "max": 1e6})
    onnx: bool = False
    weights_bits: GraphBits = GRAPH_BITS
