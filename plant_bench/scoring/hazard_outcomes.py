"""What became of hazards, by kind: how many were met, and how many of those without a collision."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from plant_bench.scoring.infractions import COLLISIONS
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.world.hazard import HazardKind, Phase

NEAR = 30.0  # m along the route, either way: a collision there is put down to the hazard
MET = (Phase.COMMITTED, Phase.DONE)


@dataclass(frozen=True)
class HazardCount:
    """The hazards of one kind in a run.

    Attributes:
        placed: All on the routes driven.
        met: Of them, those that took their course.
        survived: Of the met, those without a collision near them once they had begun.
        void: Of the placed, those called off since they could not be fair.
    """

    placed: int
    met: int
    survived: int
    void: int


def hazard_counts(results: Sequence[EpisodeResult]) -> dict[HazardKind, HazardCount]:
    """Return the counts of each kind that was placed, in the order of `HazardKind`."""
    pairs = [(item, hazard) for item in results for hazard in item.hazards]
    found = {kind: [pair for pair in pairs if pair[1].kind is kind] for kind in HazardKind}
    return {kind: _count(of_kind) for kind, of_kind in found.items() if of_kind}


def survived(result: EpisodeResult, hazard: HazardRecord) -> bool:
    """Return whether the ego came past a hazard that it met without a collision.

    Where two hazards lie within `NEAR` of each other, a collision is put down to both.
    """
    return not any(
        item.kind in COLLISIONS
        and item.time >= hazard.time
        and abs(item.progress - hazard.at) <= NEAR
        for item in result.infractions
    )


def _count(pairs: Iterable[tuple[EpisodeResult, HazardRecord]]) -> HazardCount:
    pairs = list(pairs)
    met = [(result, hazard) for result, hazard in pairs if hazard.phase in MET]
    return HazardCount(
        placed=len(pairs),
        met=len(met),
        survived=sum(survived(result, hazard) for result, hazard in met),
        void=sum(hazard.phase is Phase.VOID for _, hazard in pairs),
    )
