"""What is measured of an episode beyond the score: one function a metric, named as in records.

A function under `@episode_metric` is all that a record needs; `scoring.metrics_table` says how it
is shown and summed up over a run. What stands here decides what records hold, so that an episode's
key depends on it; nothing of `metrics_table` does.

For comparison, Bench2Drive calls a drive comfortable below 4.05 m/s2 of braking, 4.13 m/s3 of
longitudinal jerk and 4.89 m/s2 to the side. Numbers here are smoothed over half a second, since a
planner that is asked 20 times a second may change its mind as often.
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
BRAKING_APART = 1.0  # s between two events of braking: own choice, below it they are one
HALF_SECOND = 10  # ticks
PERCENTILE = 95.0
AROUND = 50.0  # m: own choice; leaderboard 2.0 takes the whole map

_Measured = TypeVar("_Measured", bound=Callable[[Trajectory], float | None])


@dataclass(frozen=True)
class EpisodeMetric:
    """A metric of one episode.

    Attributes:
        of: Measures an episode of at least one tick; None where there is nothing to measure.
        since: The first format of records that has it.
    """

    of: Callable[[Trajectory], float | None]
    since: int

    @property
    def whole(self) -> bool:
        """Whether it is a count, by what its function says that it returns."""
        return getattr(self.of, "__annotations__", {}).get("return") in (int, "int")


EPISODE_METRICS: dict[str, EpisodeMetric] = {}  # by name, in the order of records


def episode_metric(*, since: int) -> Callable[[_Measured], _Measured]:
    """Make a function a metric of every episode, under the function's name.

    Args:
        since: The first format of records that has it: for a new one, `RESULT_FORMAT` + 1.
    """

    def register(function: _Measured) -> _Measured:
        EPISODE_METRICS[function.__name__] = EpisodeMetric(function, since)
        return function

    return register


@episode_metric(since=2)
def ttc_vehicle(trajectory: Trajectory) -> float | None:
    """Return the least time to collision with a vehicle, seconds."""
    return least_time_to_collision(trajectory, trajectory.of_kinds(VEHICLES))


@episode_metric(since=2)
def ttc_vulnerable(trajectory: Trajectory) -> float | None:
    """Return the least time to collision with a pedestrian or a cyclist, seconds."""
    return least_time_to_collision(trajectory, trajectory.of_kinds(VULNERABLE))


@episode_metric(since=2)
def pet_vehicle(trajectory: Trajectory) -> float | None:
    """Return the least post-encroachment time with a vehicle whose path crosses the ego's."""
    return least_post_encroachment_time(trajectory, trajectory.of_kinds(VEHICLES))


@episode_metric(since=2)
def pet_vulnerable(trajectory: Trajectory) -> float | None:
    """Return the least post-encroachment time with a pedestrian or a cyclist, seconds."""
    return least_post_encroachment_time(trajectory, trajectory.of_kinds(VULNERABLE))


@episode_metric(since=2)
def hard_brakes(trajectory: Trajectory) -> int:
    """Return how often the ego braked harder than `HARD_BRAKING`."""
    hard = np.flatnonzero(trajectory.accelerations < HARD_BRAKING)
    if not hard.size:
        return 0
    return 1 + int((np.diff(hard) * TICK > BRAKING_APART).sum())


@episode_metric(since=2)
def hard_brake_share(trajectory: Trajectory) -> float:
    """Return the share of time in which it did."""
    return float((trajectory.accelerations < HARD_BRAKING).mean())


@episode_metric(since=2)
def jerk_p95(trajectory: Trajectory) -> float | None:
    """Return the 95th percentile of longitudinal jerk, either way, while the ego moved; m/s3.

    Jerk is the change of mean acceleration from one half-second to the next.
    """
    step = HALF_SECOND
    speed = trajectory.speeds
    change = speed[2 * step :] - 2.0 * speed[step:-step] + speed[: -2 * step]
    return _percentile(change / (step * TICK) ** 2, speed[step:-step])


@episode_metric(since=2)
def lateral_acceleration_p95(trajectory: Trajectory) -> float | None:
    """Return the 95th percentile of speed times rate of turn, either way, while moving; m/s2."""
    step = HALF_SECOND // 2
    speed = trajectory.speeds[step:-step]
    yaw = np.unwrap(trajectory.poses[:, 2])
    turn = (yaw[2 * step :] - yaw[: -2 * step]) / (2 * step * TICK)
    return _percentile(speed * turn, speed)


@episode_metric(since=2)
def relative_speed(trajectory: Trajectory) -> float | None:
    """Return the ego's mean speed over that of the vehicles around it, as leaderboard 2.0 does.

    Vehicles in any direction within `AROUND` count, waiting ones too. Those that never moved in
    sight are parked, and those that follow the ego go as fast as it lets them: neither counts.
    Moments without any vehicle count for neither speed. None if there was none ever.
    """
    others = trajectory.of_kinds(VEHICLES)
    others = others.only(_traffic(trajectory, others))
    size = len(trajectory.sample_ticks)
    number = np.bincount(others.samples, minlength=size)
    total = np.bincount(others.samples, others.actors.speeds, minlength=size)
    met = number > 0
    traffic = float((total[met] / number[met]).sum())
    return float(trajectory.sample_speeds[met].sum()) / traffic if traffic > 0.0 else None


@episode_metric(since=2)
def standing_share(trajectory: Trajectory) -> float:
    """Return the share of time in which the ego stood."""
    return float((trajectory.speeds < BLOCKED_SPEED).mean())


@episode_metric(since=2)
def off_lane_distance(trajectory: Trajectory) -> float:
    """Return the metres driven off all lanes."""
    return trajectory.off_lane


@episode_metric(since=2)
def wrong_lane_distance(trajectory: Trajectory) -> float:
    """Return the metres driven on lanes of the other direction."""
    return trajectory.wrong_lane


def _percentile(values: np.ndarray, speeds: np.ndarray) -> float | None:
    moving = np.abs(values[speeds >= BLOCKED_SPEED])
    return float(np.percentile(moving, PERCENTILE)) if moving.size else None


def _traffic(trajectory: Trajectory, others: ActorSamples) -> np.ndarray:
    """Return a mask of the actor_samples that are of the traffic around the ego."""
    actors, ego = others.actors, trajectory.sample_poses[others.samples]
    apart = actors.poses[:, :2] - ego[:, :2]
    around = np.hypot(apart[:, 0], apart[:, 1]) <= AROUND
    _, who = np.unique(actors.ids, return_inverse=True)
    fastest = np.zeros(who.max(initial=-1) + 1)
    np.maximum.at(fastest, who, actors.speeds)
    return around & ~followers(trajectory, others) & (fastest[who] >= BLOCKED_SPEED)
