"""How smoothly the ego drove: hard braking, jerk, lateral acceleration.

For comparison, Bench2Drive calls a drive comfortable below 4.05 m/s2 of braking, 4.13 m/s3 of
longitudinal jerk and 4.89 m/s2 to the side. Numbers here are smoothed over half a second, since a
planner that is asked 20 times a second may change its mind as often.
"""

import numpy as np

from plant_bench.scoring.endings import BLOCKED_SPEED
from plant_bench.scoring.track import Track
from plant_bench.world.scene import TICK

HARD_BRAKING = -4.0  # m/s2 (Bench2Drive, longitudinal comfort: -4.05)
BRAKING_APART = 1.0  # s between two events of braking: own choice, below it they are one
HALF_SECOND = 10  # ticks
PERCENTILE = 95.0


def hard_brakes(track: Track) -> int:
    """Return how often the ego braked harder than `HARD_BRAKING`."""
    hard = np.flatnonzero(track.accelerations < HARD_BRAKING)
    if not hard.size:
        return 0
    return 1 + int((np.diff(hard) * TICK > BRAKING_APART).sum())


def hard_brake_share(track: Track) -> float:
    """Return the share of time in which it did."""
    return float((track.accelerations < HARD_BRAKING).mean())


def jerk(track: Track) -> float | None:
    """Return the 95th percentile of longitudinal jerk, either way, while the ego moved; m/s3.

    Jerk is the change of mean acceleration from one half-second to the next.
    """
    step = HALF_SECOND
    speed = track.speeds
    change = speed[2 * step :] - 2.0 * speed[step:-step] + speed[: -2 * step]
    return _percentile(change / (step * TICK) ** 2, speed[step:-step])


def lateral_acceleration(track: Track) -> float | None:
    """Return the 95th percentile of speed times rate of turn, either way, while moving; m/s2."""
    step = HALF_SECOND // 2
    speed = track.speeds[step:-step]
    yaw = np.unwrap(track.poses[:, 2])
    turn = (yaw[2 * step :] - yaw[: -2 * step]) / (2 * step * TICK)
    return _percentile(speed * turn, speed)


def _percentile(values: np.ndarray, speeds: np.ndarray) -> float | None:
    moving = np.abs(values[speeds >= BLOCKED_SPEED])
    return float(np.percentile(moving, PERCENTILE)) if moving.size else None
