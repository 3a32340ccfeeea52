"""How near the ego came to a collision in time: time to collision and post-encroachment time.

Both are least values over an episode, of boxes at full size, to the tenth of a second or so: the
others are looked at five times a second.
"""

import math

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.geometry.box import overlap
from plant_bench.scoring.collisions import STANDING
from plant_bench.scoring.driven_paths import EgoPath, OtherPaths, followers
from plant_bench.scoring.trajectory import SAMPLE, ActorSamples, Trajectory
from plant_bench.world.scene import EGO_EXTENT

TTC_HORIZON = 5.0  # s: own choice; beyond it nobody is near
TTC_STEP = 0.1  # s: to this, TTC is exact; at 40 m/s of closing, boxes do not slip through
PET_HORIZON = 5.0  # s (FHWA-HRT-08-051, SSAM: default maximum of PET)
# Own choice, between SSAM's 30 (lane change) and 85 (crossing): who follows another through a tight
# turn stays below it.
CROSSING = math.radians(60.0)  # least angle between the headings of two whose paths cross

_EGO_REACH = 0.5 * math.hypot(*EGO_EXTENT)


def least_time_to_collision(trajectory: Trajectory, others: ActorSamples) -> float | None:
    """Return the least TTC: in what time boxes would overlap if the speeds were kept.

    Ego and actor go on along the paths that they then took, each at the speed it had: so a bend is
    no course of collision, and braking is what saves. Who follows the ego does not count. 0 where
    boxes do overlap; None above `TTC_HORIZON`.
    """
    others = others.only(~followers(trajectory, others))
    if not len(others.actors):
        return None
    ego, paths = EgoPath(trajectory), OtherPaths(others)
    closing = trajectory.sample_speeds[others.samples] + others.actors.speeds
    reach = _EGO_REACH + 0.5 * np.hypot(*others.actors.extents.T)
    due = np.zeros(len(closing))  # s ahead; before it, the two cannot meet
    for step in range(round(TTC_HORIZON / TTC_STEP) + 1):
        time = step * TTC_STEP
        rows = np.flatnonzero(due <= time)
        times = np.full(len(rows), time)
        mine, theirs = ego.ahead(others.samples[rows], times), paths.ahead(rows, times)
        gap = np.hypot(*(theirs[:, :2] - mine[:, :2]).T) - reach[rows]
        due[rows] = time + np.maximum(gap, 0.0) / np.maximum(closing[rows], STANDING)
        near = gap < 0.0
        if _overlap_ego(mine[near], theirs[near], others.actors.extents[rows[near]]):
            return time
    return None


def _overlap_ego(
    ego: Float[np.ndarray, "pairs 3"],
    others: Float[np.ndarray, "pairs 3"],
    extents: Float[np.ndarray, "pairs 2"],
) -> bool:
    """Tell whether any of these boxes overlaps the ego's beside it."""
    if not len(ego):
        return False
    return bool(overlap(ego, np.tile(EGO_EXTENT, (len(ego), 1)), others, extents).any())


def least_post_encroachment_time(trajectory: Trajectory, others: ActorSamples) -> float | None:
    """Return the least PET: the shift in time at which the ego and a crossing actor would have met.

    That is the least difference of two moments such that the ego's box at the one overlaps the
    other's at the other moment, their headings at least `CROSSING` apart: the time between one
    leaving what both drove over and the other reaching it, to one sample. None above `PET_HORIZON`.
    """
    lags = round(PET_HORIZON / SAMPLE)
    others = others.only(_near_the_path(trajectory, others, lags))
    if not len(others.actors):
        return None
    for lag in range(lags + 1):
        if any(_met(trajectory, others, shift) for shift in {lag, -lag}):
            return lag * SAMPLE
    return None


def _near_the_path(
    trajectory: Trajectory, others: ActorSamples, lags: int
) -> Bool[np.ndarray, " actors"]:
    """Tell who was within reach of the rectangle that the ego drove through around that time."""
    places = trajectory.sample_poses[:, :2]
    low, high = places.copy(), places.copy()
    for lag in range(1, min(lags, len(places) - 1) + 1):
        low[lag:] = np.minimum(low[lag:], places[:-lag])
        low[:-lag] = np.minimum(low[:-lag], places[lag:])
        high[lag:] = np.maximum(high[lag:], places[:-lag])
        high[:-lag] = np.maximum(high[:-lag], places[lag:])
    where, actors = others.samples, others.actors
    reach = (_EGO_REACH + 0.5 * np.hypot(*actors.extents.T))[:, None]
    inside = (actors.poses[:, :2] > low[where] - reach) & (
        actors.poses[:, :2] < high[where] + reach
    )
    return inside.all(axis=1)


def _met(trajectory: Trajectory, others: ActorSamples, shift: int) -> bool:
    """Tell whether an actor overlaps the ego of that many samples later, on a crossing course."""
    actors, sample = others.actors, others.samples + shift
    inside = (sample >= 0) & (sample < len(trajectory.sample_ticks))
    ego = trajectory.sample_poses[np.where(inside, sample, 0)]
    reach = _EGO_REACH + 0.5 * np.hypot(*actors.extents.T)
    distance = np.hypot(*(actors.poses[:, :2] - ego[:, :2]).T)
    near = inside & (distance < reach)
    near &= np.cos(actors.poses[:, 2] - ego[:, 2]) <= math.cos(CROSSING)
    return _overlap_ego(ego[near], actors.poses[near], actors.extents[near])
