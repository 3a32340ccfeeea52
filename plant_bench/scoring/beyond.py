"""The measures of many episodes, summed up; no part of any score."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.measures import Measures
from plant_bench.scoring.normalised import LEAST_KM, kilometres
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.scene import ActorKind

COLLISIONS = (
    InfractionKind.COLLISION_PEDESTRIAN,
    InfractionKind.COLLISION_VEHICLE,
    InfractionKind.COLLISION_STATIC,
)


@dataclass(frozen=True)
class Beyond:
    """Measures of a run; nan where there was nothing to measure.

    Least times are infinite where the middle episode had no near miss at all.

    Attributes:
        episodes: Number of episodes with measures.
        ttc_vehicle: Median over episodes of the least time to collision with a vehicle, seconds.
        ttc_vulnerable: As above, with a pedestrian or cyclist.
        pet_vehicle: Median of the least post-encroachment time with a vehicle, seconds.
        pet_vulnerable: As above, with a pedestrian or cyclist.
        hard_brakes_per_km: All events over all kilometres.
        hard_brake_share: Share of time, over all episodes.
        jerk_p95: Mean over episodes of each one's 95th percentile, m/s3.
        lateral_acceleration_p95: As above, m/s2.
        relative_speed: Mean over episodes of the speed relative to traffic.
        standing_share: Share of time, over all episodes.
        off_lane_per_km: Kilometres off all lanes per kilometre.
        wrong_lane_per_km: Kilometres on lanes of the other direction per kilometre.
    """

    episodes: int
    ttc_vehicle: float
    ttc_vulnerable: float
    pet_vehicle: float
    pet_vulnerable: float
    hard_brakes_per_km: float
    hard_brake_share: float
    jerk_p95: float
    lateral_acceleration_p95: float
    relative_speed: float
    standing_share: float
    off_lane_per_km: float
    wrong_lane_per_km: float


def beyond_the_score(results: Sequence[EpisodeResult]) -> Beyond:
    """Sum up the measures of episodes; those without any are left out."""
    measured = [(item, item.measures) for item in results if item.measures is not None]
    found = [measures for _, measures in measured]
    metres = 1000.0 * max(kilometres([item for item, _ in measured]), LEAST_KM)
    seconds = sum(item.duration for item, _ in measured)

    def of_time(name: str) -> float:
        total = sum(getattr(measures, name) * item.duration for item, measures in measured)
        return total / seconds if seconds > 0.0 else math.nan

    def per_metre(name: str) -> float:
        return sum(getattr(item, name) for item in found) / metres if found else math.nan

    return Beyond(
        episodes=len(found),
        ttc_vehicle=_median(item.ttc_vehicle for item in found),
        ttc_vulnerable=_median(item.ttc_vulnerable for item in found),
        pet_vehicle=_median(item.pet_vehicle for item in found),
        pet_vulnerable=_median(item.pet_vulnerable for item in found),
        hard_brakes_per_km=1000.0 * per_metre("hard_brakes"),
        hard_brake_share=of_time("hard_brake_share"),
        jerk_p95=_mean(item.jerk_p95 for item in found),
        lateral_acceleration_p95=_mean(item.lateral_acceleration_p95 for item in found),
        relative_speed=_mean(item.relative_speed for item in found),
        standing_share=of_time("standing_share"),
        off_lane_per_km=per_metre("off_lane_distance"),
        wrong_lane_per_km=per_metre("wrong_lane_distance"),
    )


def collisions_with(result: EpisodeResult, kind: ActorKind) -> int:
    """Return the number of an episode's collisions with actors of one kind."""
    return sum(item.actor_kind == kind for item in result.infractions if item.kind in COLLISIONS)


def measure_row(measures: Measures | None) -> dict[str, object]:
    """Return the columns of an episode's measures; empty cells where there are none."""
    return {name: getattr(measures, name, None) for name in Measures.model_fields}


def _median(values: Iterable[float | None]) -> float:
    known = sorted(math.inf if value is None else value for value in values)
    if not known:
        return math.nan
    low, high = known[(len(known) - 1) // 2], known[len(known) // 2]
    return low if low == high else 0.5 * (low + high)


def _mean(values: Iterable[float | None]) -> float:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else math.nan
