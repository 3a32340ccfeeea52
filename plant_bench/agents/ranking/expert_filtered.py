"""The planner `expert-filtered`: the expert sees only the top-ranked vehicle (PlanT, 4.3: RFDS)."""

from collections.abc import Sequence
from pathlib import Path

from plant_bench.agent import Agent, Ranker
from plant_bench.agents.expert import Expert
from plant_bench.agents.loading.checksum import PlannerComponents, components_of
from plant_bench.agents.loading.planner_spec import Kind, PlannerSpec
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.ranking.filtered_planner import Filtered
from plant_bench.agents.ranking.masking import Masking
from plant_bench.agents.ranking.rankers import Nearest, Oracle, Random
from plant_bench.errors import InputError

ATTENTION, MASKING, NO_VEHICLE = "attention", "masking", "none"
PLANNER_RANKERS = (ATTENTION, MASKING)
BASELINE_RANKERS: dict[str, type[Ranker]] = {
    "distance": Nearest,
    "random": Random,
    "oracle": Oracle,
}
RANKERS = (*PLANNER_RANKERS, *BASELINE_RANKERS, NO_VEHICLE)


class FilteredExpert(Filtered):
    """The expert, which sees only the highest-ranked vehicle and all pedestrians.

    Attributes:
        files: The files that determine the ranks, apart from plant-bench's own code.
        libraries: The packages that it computes with.

    Args:
        ranking: "distance", "random", "oracle", "none" (no vehicle is visible), "attention:AGENT"
            for a planner's own `rank`, or "masking:AGENT" for any planner; AGENT is as for
            `load_agent`.

    Raises:
        InputError: There is no such ranker or planner, or the planner cannot rank.
    """

    def __init__(self, ranking: str = "oracle") -> None:
        name, _, planner = ranking.partition(":")
        if name not in RANKERS or bool(planner) != (name in PLANNER_RANKERS):
            message = (
                f"There is no ranking '{ranking}': expected {', '.join(BASELINE_RANKERS)}, "
                f"{NO_VEHICLE}, attention:AGENT or masking:AGENT."
            )
            raise InputError(message)
        ranker = _ranker_of(name, planner) if planner else BASELINE_RANKERS.get(name, Nearest)()
        components = components_of(planner) if planner else PlannerComponents()
        self.files: Sequence[Path] = sorted(components.files)
        self.libraries = sorted({"numba", "numpy", *components.libraries})
        super().__init__(Expert(), ranker, most=int(name != NO_VEHICLE), vehicles_only=True)


def ranks_itself(agent: Agent) -> bool:
    """Return whether a planner can rank the actors."""
    return isinstance(agent, Ranker)


def _ranker_of(name: str, planner: str) -> Ranker:
    if name == MASKING and PlannerSpec.parse(planner).kind is Kind.COMMAND:
        message = (
            f"'{planner}' cannot be ranked by masking, which runs copies of a planner: a planner "
            'in another process cannot be copied. Implement "rank" '
            "(docs/reference/protocol-agents.md)."
        )
        raise InputError(message)
    agent = load_agent(planner)
    if name == MASKING:
        return Masking(agent)
    if not isinstance(agent, Ranker):
        message = f"'{planner}' has no `rank`: use masking, which works with any planner."
        raise InputError(message)
    return agent
