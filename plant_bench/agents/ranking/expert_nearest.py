"""The planner `expert-nearest`, a baseline: the expert sees only the nearest actor."""

from plant_bench.agents.expert import Expert
from plant_bench.agents.ranking.filtered_planner import Filtered
from plant_bench.agents.ranking.rankers import Nearest


def expert_nearest() -> Filtered:
    """Let the expert see only the nearest actor (PlanT, section 4.3, inverse distance)."""
    return Filtered(Expert(), Nearest(), most=1)
