"""What is measured of an episode beyond the score; no law knows of it.

Derived from scenes alone, when the episode is over, so that rescoring comes to the same numbers.
"""

from pydantic import BaseModel, ConfigDict

from plant_bench.scoring import flow, near_misses, smoothness
from plant_bench.scoring.track import VEHICLES, VULNERABLE, Track

DIGITS = 4  # of a measure in a record


class Measures(BaseModel):
    """Measures of one episode; None where there was nothing to measure.

    Attributes:
        ttc_vehicle: Least time to collision with a vehicle, seconds.
        ttc_vulnerable: As above, with a pedestrian or a cyclist.
        pet_vehicle: Least post-encroachment time with a vehicle whose path crosses the ego's.
        pet_vulnerable: As above, with a pedestrian or a cyclist.
        hard_brakes: How often the ego braked harder than 4 m/s2.
        hard_brake_share: Share of time in which it did.
        jerk_p95: 95th percentile of longitudinal jerk, either way, m/s3.
        lateral_acceleration_p95: As above, of acceleration to the side, m/s2.
        relative_speed: The ego's mean speed over that of the traffic around it.
        standing_share: Share of time in which the ego stood.
        off_lane_distance: Metres driven off all lanes.
        wrong_lane_distance: Metres driven on lanes of the other direction.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    ttc_vehicle: float | None
    ttc_vulnerable: float | None
    pet_vehicle: float | None
    pet_vulnerable: float | None
    hard_brakes: int
    hard_brake_share: float
    jerk_p95: float | None
    lateral_acceleration_p95: float | None
    relative_speed: float | None
    standing_share: float
    off_lane_distance: float
    wrong_lane_distance: float


def measure(track: Track, *, off_lane: float, wrong_lane: float) -> Measures:
    """Measure an episode of at least one tick.

    Args:
        track: The episode.
        off_lane: Metres driven off all lanes.
        wrong_lane: Metres driven on lanes of the other direction.
    """
    vehicles, vulnerable = track.of_kinds(VEHICLES), track.of_kinds(VULNERABLE)
    found = {
        "ttc_vehicle": near_misses.least_time_to_collision(track, vehicles),
        "ttc_vulnerable": near_misses.least_time_to_collision(track, vulnerable),
        "pet_vehicle": near_misses.least_post_encroachment_time(track, vehicles),
        "pet_vulnerable": near_misses.least_post_encroachment_time(track, vulnerable),
        "hard_brakes": smoothness.hard_brakes(track),
        "hard_brake_share": smoothness.hard_brake_share(track),
        "jerk_p95": smoothness.jerk(track),
        "lateral_acceleration_p95": smoothness.lateral_acceleration(track),
        "relative_speed": flow.relative_speed(track),
        "standing_share": flow.standing_share(track),
        "off_lane_distance": off_lane,
        "wrong_lane_distance": wrong_lane,
    }
    return Measures.model_validate(
        {name: value if value is None else round(value, DIGITS) for name, value in found.items()}
    )
