"""Hazard outcomes by kind: how many were placed, triggered, and passed without a collision."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from plant_bench.scoring.infractions import COLLISIONS
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.world.hazard import HazardKind, Phase

NEAR = 30.0  # m along the route: a collision this close is attributed to the hazard
MET = (Phase.COMMITTED, Phase.DONE)


@dataclass(frozen=True)
class HazardCount:
    """The hazards of one kind in a run.

    Attributes:
        placed: Number on the routes driven.
        met: Number of placed hazards that were triggered.
        survived: Number of met hazards without a collision near them after they had begun.
        void: Number of placed hazards that were cancelled because they could not be fair.
    """

    placed: int
    met: int
    survived: int
    void: int


def hazard_counts(results: Sequence[EpisodeResult]) -> dict[HazardKind, HazardCount]:
    """Return the counts of each kind that was placed, in the order of `HazardKind`."""
    pairs = [(item, hazard) for item in results for hazard in item.hazards]
    by_kind = {kind: [pair for pair in pairs if pair[1].kind is kind] for kind in HazardKind}
    return {kind: _count(of_kind) for kind, of_kind in by_kind.items() if of_kind}


def survived(result: EpisodeResult, hazard: HazardRecord) -> bool:
    """Return whether the ego passed a triggered hazard without a collision.

    If two hazards lie within `NEAR` of each other, a collision is attributed to both.
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
