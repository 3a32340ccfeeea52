"""Episode metrics besides the score: near misses, comfort, lane keeping.

Each is a function under `@episode_metric`, named as in records; `scoring.metrics_table` says how it
is shown and aggregated over a run. This module decides what records contain, so an episode's key
depends on it, but not on `metrics_table`.

For comparison, Bench2Drive calls a drive comfortable below 4.05 m/s2 of braking, 4.13 m/s3 of
longitudinal jerk and 4.89 m/s2 of lateral acceleration. Metrics here are smoothed over half a
second, since a planner called 20 times a second may change its decision at every call.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from plant_bench.scoring.driven_paths import followers
from plant_bench.scoring.near_misses import least_post_encroachment_time, least_time_to_collision
from plant_bench.scoring.termination import BLOCKED_SPEED
from plant_bench.scoring.trajectory import VEHICLES, VULNERABLE, ActorSamples, Trajectory
from plant_bench.world.scene import TICK

HARD_BRAKING = -4.0  # m/s2 (Bench2Drive, longitudinal comfort: -4.05)
BRAKING_GAP = 1.0  # s: own choice; braking events closer together are one
HALF_SECOND = 10  # ticks
PERCENTILE = 95.0
TRAFFIC_RADIUS = 50.0  # m: own choice; leaderboard 2.0 takes the whole map

_Measured = TypeVar("_Measured", bound=Callable[[Trajectory], float | None])


@dataclass(frozen=True)
class EpisodeMetric:
    """A metric of one episode.

    Attributes:
        compute: Value for an episode of at least one tick; None if there is nothing to measure.
        since: The first record format that has it.
    """

    compute: Callable[[Trajectory], float | None]
    since: int

    @property
    def is_count(self) -> bool:
        """Whether its values are integers, by the return annotation of its function."""
        return getattr(self.compute, "__annotations__", {}).get("return") in (int, "int")


EPISODE_METRICS: dict[str, EpisodeMetric] = {}  # by name, in the order of records


def episode_metric(*, since: int) -> Callable[[_Measured], _Measured]:
    """Register a function as an episode metric under the function's name.

    Args:
        since: The first record format that has it; for a new metric, `RESULT_FORMAT` + 1.
    """

    def register(function: _Measured) -> _Measured:
        EPISODE_METRICS[function.__name__] = EpisodeMetric(function, since)
        return function

    return register


@episode_metric(since=2)
def ttc_vehicle(trajectory: Trajectory) -> float | None:
    """Return the minimum time to collision with a vehicle, seconds."""
    return least_time_to_collision(trajectory, trajectory.of_kinds(VEHICLES))


@episode_metric(since=2)
def ttc_vulnerable(trajectory: Trajectory) -> float | None:
    """Return the minimum time to collision with a pedestrian or a cyclist, seconds."""
    return least_time_to_collision(trajectory, trajectory.of_kinds(VULNERABLE))


@episode_metric(since=2)
def pet_vehicle(trajectory: Trajectory) -> float | None:
    """Return the minimum post-encroachment time with a vehicle whose path crosses the ego's."""
    return least_post_encroachment_time(trajectory, trajectory.of_kinds(VEHICLES))


@episode_metric(since=2)
def pet_vulnerable(trajectory: Trajectory) -> float | None:
    """Return the minimum post-encroachment time with a pedestrian or a cyclist, seconds."""
    return least_post_encroachment_time(trajectory, trajectory.of_kinds(VULNERABLE))


@episode_metric(since=2)
def hard_brakes(trajectory: Trajectory) -> int:
    """Return the number of times that the ego braked harder than `HARD_BRAKING`."""
    hard = np.flatnonzero(trajectory.accelerations < HARD_BRAKING)
    if not hard.size:
        return 0
    return 1 + int((np.diff(hard) * TICK > BRAKING_GAP).sum())


@episode_metric(since=2)
def hard_brake_share(trajectory: Trajectory) -> float:
    """Return the share of time in which the ego braked harder than `HARD_BRAKING`."""
    return float((trajectory.accelerations < HARD_BRAKING).mean())


@episode_metric(since=2)
def jerk_p95(trajectory: Trajectory) -> float | None:
    """Return the 95th percentile of absolute longitudinal jerk while the ego moved, m/s3.

    Jerk is the change of mean acceleration from one half second to the next.
    """
    step = HALF_SECOND
    speed = trajectory.speeds
    change = speed[2 * step :] - 2.0 * speed[step:-step] + speed[: -2 * step]
    return _percentile(change / (step * TICK) ** 2, speed[step:-step])


@episode_metric(since=2)
def lateral_acceleration_p95(trajectory: Trajectory) -> float | None:
    """Return the 95th percentile of absolute speed times yaw rate while the ego moved, m/s2."""
    step = HALF_SECOND // 2
    speed = trajectory.speeds[step:-step]
    yaw = np.unwrap(trajectory.poses[:, 2])
    turn = (yaw[2 * step :] - yaw[: -2 * step]) / (2 * step * TICK)
    return _percentile(speed * turn, speed)


@episode_metric(since=2)
def relative_speed(trajectory: Trajectory) -> float | None:
    """Return the ego's mean speed divided by that of surrounding vehicles, as leaderboard 2.0 does.

    All vehicles within `TRAFFIC_RADIUS` count, waiting ones included, except those that never moved
    while in range (parked) and those that follow the ego (it limits their speed). Samples without
    any such vehicle are left out of both means. None if no sample has one.
    """
    others = trajectory.of_kinds(VEHICLES)
    others = others.only(_traffic(trajectory, others))
    size = len(trajectory.sample_ticks)
    number = np.bincount(others.samples, minlength=size)
    total = np.bincount(others.samples, others.actors.speeds, minlength=size)
    busy = number > 0
    traffic = float((total[busy] / number[busy]).sum())
    return float(trajectory.sample_speeds[busy].sum()) / traffic if traffic > 0.0 else None


@episode_metric(since=2)
def standing_share(trajectory: Trajectory) -> float:
    """Return the share of time in which the ego was stationary."""
    return float((trajectory.speeds < BLOCKED_SPEED).mean())


@episode_metric(since=2)
def off_lane_distance(trajectory: Trajectory) -> float:
    """Return the metres driven off all lanes."""
    return trajectory.off_lane


@episode_metric(since=2)
def wrong_lane_distance(trajectory: Trajectory) -> float:
    """Return the metres driven on lanes of the opposite direction."""
    return trajectory.wrong_lane


def _percentile(values: np.ndarray, speeds: np.ndarray) -> float | None:
    moving = np.abs(values[speeds >= BLOCKED_SPEED])
    return float(np.percentile(moving, PERCENTILE)) if moving.size else None


def _traffic(trajectory: Trajectory, others: ActorSamples) -> np.ndarray:
    """Return a mask of the samples of moving traffic around the ego."""
    actors, ego = others.actors, trajectory.sample_poses[others.samples]
    offset = actors.poses[:, :2] - ego[:, :2]
    nearby = np.hypot(offset[:, 0], offset[:, 1]) <= TRAFFIC_RADIUS
    _, actor = np.unique(actors.ids, return_inverse=True)
    fastest = np.zeros(actor.max(initial=-1) + 1)
    np.maximum.at(fastest, actor, actors.speeds)
    return nearby & ~followers(trajectory, others) & (fastest[actor] >= BLOCKED_SPEED)
