"""Near misses: minimum time to collision (TTC) and post-encroachment time (PET) of an episode.

Both use full-size bounding boxes. Other actors are sampled five times a second.
"""

import math

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.geometry.box import overlap
from plant_bench.scoring.collisions import STATIONARY
from plant_bench.scoring.driven_paths import EgoPath, OtherPaths, followers
from plant_bench.scoring.trajectory import SAMPLE, ActorSamples, Trajectory
from plant_bench.world.scene import EGO_EXTENT

TTC_HORIZON = 5.0  # s: own choice; a longer time is not a near miss
TTC_STEP = 0.1  # s: resolution; small enough for boxes not to skip each other closing at 40 m/s
PET_HORIZON = 5.0  # s (FHWA-HRT-08-051, SSAM: default maximum of PET)
# Own choice, between SSAM's 30 (lane change) and 85 (crossing): the headings of a vehicle and its
# follower in a tight turn differ by less.
CROSSING = math.radians(60.0)  # least angle between the headings for paths to count as crossing

_EGO_REACH = 0.5 * math.hypot(*EGO_EXTENT)


def least_time_to_collision(trajectory: Trajectory, others: ActorSamples) -> float | None:
    """Return the minimum TTC: the time until boxes would overlap at constant speeds.

    Ego and actor move along the paths that they actually drove, so that a bend is not a collision
    course. Actors that follow the ego do not count. 0 if boxes overlap; None above `TTC_HORIZON`.
    """
    others = others.only(~followers(trajectory, others))
    if not len(others.actors):
        return None
    ego, paths = EgoPath(trajectory), OtherPaths(others)
    closing = trajectory.sample_speeds[others.samples] + others.actors.speeds
    reach = _EGO_REACH + 0.5 * np.hypot(*others.actors.extents.T)
    due = np.zeros(len(closing))  # s ahead; the boxes cannot overlap before
    for step in range(round(TTC_HORIZON / TTC_STEP) + 1):
        time = step * TTC_STEP
        rows = np.flatnonzero(due <= time)
        times = np.full(len(rows), time)
        egos, actors = ego.ahead(others.samples[rows], times), paths.ahead(rows, times)
        gap = np.hypot(*(actors[:, :2] - egos[:, :2]).T) - reach[rows]
        due[rows] = time + np.maximum(gap, 0.0) / np.maximum(closing[rows], STATIONARY)
        near = gap < 0.0
        if _overlap_ego(egos[near], actors[near], others.actors.extents[rows[near]]):
            return time
    return None


def _overlap_ego(
    ego: Float[np.ndarray, "pairs 3"],
    others: Float[np.ndarray, "pairs 3"],
    extents: Float[np.ndarray, "pairs 2"],
) -> bool:
    """Return whether any of these boxes overlaps the ego's box of the same row."""
    if not len(ego):
        return False
    return bool(overlap(ego, np.tile(EGO_EXTENT, (len(ego), 1)), others, extents).any())


def least_post_encroachment_time(trajectory: Trajectory, others: ActorSamples) -> float | None:
    """Return the minimum PET: the time between ego and actor occupying the same place.

    That is the smallest time difference at which the ego's box overlaps an actor's box, their
    headings at least `CROSSING` apart: the time from one leaving the shared area to the other
    entering it, to a resolution of one sample. None above `PET_HORIZON`.
    """
    lags = round(PET_HORIZON / SAMPLE)
    others = others.only(_near_the_path(trajectory, others, lags))
    if not len(others.actors):
        return None
    for lag in range(lags + 1):
        if any(_overlaps_shifted(trajectory, others, shift) for shift in {lag, -lag}):
            return lag * SAMPLE
    return None


def _near_the_path(
    trajectory: Trajectory, others: ActorSamples, lags: int
) -> Bool[np.ndarray, " actors"]:
    """Return a mask of actors that can touch the rectangle driven through by the ego around then.

    `lags` is the number of samples before and after.
    """
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


def _overlaps_shifted(trajectory: Trajectory, others: ActorSamples, shift: int) -> bool:
    """Return whether an actor overlaps the ego's box `shift` samples later, on a crossing path."""
    actors, sample = others.actors, others.samples + shift
    inside = (sample >= 0) & (sample < len(trajectory.sample_ticks))
    ego = trajectory.sample_poses[np.where(inside, sample, 0)]
    reach = _EGO_REACH + 0.5 * np.hypot(*actors.extents.T)
    distance = np.hypot(*(actors.poses[:, :2] - ego[:, :2]).T)
    near = inside & (distance < reach)
    near &= np.cos(actors.poses[:, 2] - ego[:, 2]) <= math.cos(CROSSING)
    return _overlap_ego(ego[near], actors.poses[near], actors.extents[near])
