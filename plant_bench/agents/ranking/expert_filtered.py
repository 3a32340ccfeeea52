"""The expert that sees one vehicle alone: whom a ranker puts first (PlanT, section 4.3: RFDS)."""

from collections.abc import Sequence
from pathlib import Path

from plant_bench.agent import Agent, Ranker
from plant_bench.agents.expert import Expert
from plant_bench.agents.loading.checksum import Makings, makings_of
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.loading.spec import Kind, PlannerSpec
from plant_bench.agents.ranking.filtered import Filtered
from plant_bench.agents.ranking.masking import Masking
from plant_bench.agents.ranking.rankers import Nearest, Oracle, Random
from plant_bench.errors import InputError

ATTENTION, MASKING, NOBODY_SHOWN = "attention", "masking", "none"
OF_A_PLANNER = (ATTENTION, MASKING)
BY_THEMSELVES: dict[str, type[Ranker]] = {"distance": Nearest, "random": Random, "oracle": Oracle}
RANKERS = (*OF_A_PLANNER, *BY_THEMSELVES, NOBODY_SHOWN)


class FilteredExpert(Filtered):
    """The expert, shown the one vehicle that ranks highest, and all pedestrians.

    Attributes:
        files: What decides the ranks, apart from plant-bench's own code.
        libraries: What it computes with.

    Args:
        ranking: "distance", "random", "oracle", "none" (no vehicle is shown), or who ranks and how:
            "attention:AGENT" for a planner's own `rank`, "masking:AGENT" for any planner; AGENT is
            as for `load_agent`.

    Raises:
        InputError: There is no such ranker or planner, or the planner cannot rank.
    """

    def __init__(self, ranking: str = "oracle") -> None:
        name, _, planner = ranking.partition(":")
        if name not in RANKERS or bool(planner) != (name in OF_A_PLANNER):
            message = (
                f"There is no ranking '{ranking}': {', '.join([*BY_THEMSELVES, NOBODY_SHOWN])}, "
                "or attention:AGENT or masking:AGENT is wanted."
            )
            raise InputError(message)
        ranker = _ranker_of(name, planner) if planner else BY_THEMSELVES.get(name, Nearest)()
        makings = makings_of(planner) if planner else Makings()
        self.files: Sequence[Path] = sorted(makings.files)
        self.libraries = sorted({"numba", "numpy", *makings.libraries})
        super().__init__(Expert(), ranker, most=int(name != NOBODY_SHOWN), vehicles_only=True)


def ranks_itself(agent: Agent) -> bool:
    """Tell whether a planner says which actors matter to it."""
    return isinstance(agent, Ranker)


def _ranker_of(name: str, planner: str) -> Ranker:
    if name == MASKING and PlannerSpec.parse(planner).kind is Kind.COMMAND:
        message = (
            f"'{planner}' cannot be ranked by masking, which asks copies of a planner: what is in "
            'another process cannot be copied. Let it answer "rank" '
            "(docs/reference/protocol-agents.md)."
        )
        raise InputError(message)
    agent = load_agent(planner)
    if name == MASKING:
        return Masking(agent)
    if not isinstance(agent, Ranker):
        message = f"'{planner}' has no `rank`: rank by masking, which asks any planner."
        raise InputError(message)
    return agent
