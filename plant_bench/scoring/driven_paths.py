"""Future poses of ego and actors at constant speed along the paths they actually drove.

Paths come from the finished episode: straight-line extrapolation in a bend would predict collisions
with everything that waits beside the road.
"""

import numpy as np
from jaxtyping import Bool, Float, Int

from plant_bench.geometry.pose import wrap_angles
from plant_bench.scoring.trajectory import ActorSamples, Trajectory

SAME_DIRECTION = np.cos(np.radians(45.0))  # least cosine between two headings: own choice


class EgoPath:
    """The ego's path of an episode, extended straight beyond its end.

    Args:
        trajectory: The episode.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        step = np.hypot(*np.diff(trajectory.poses[:, :2], axis=0).T)
        arc = np.concatenate(([0.0], np.cumsum(step)))
        self._start = arc[trajectory.sample_ticks]
        self._speeds = trajectory.sample_speeds
        self._arc = arc
        self._x, self._y = trajectory.poses[:, 0], trajectory.poses[:, 1]
        self._yaw = np.unwrap(trajectory.poses[:, 2])

    def ahead(
        self, samples: Int[np.ndarray, " actors"], times: Float[np.ndarray, " actors"]
    ) -> Float[np.ndarray, "actors 3"]:
        """Return the poses `times` seconds after the samples, at the speed of each sample."""
        arc = self._start[samples] + self._speeds[samples] * times
        beyond = np.maximum(arc - self._arc[-1], 0.0)
        yaw = np.interp(arc, self._arc, self._yaw)
        x = np.interp(arc, self._arc, self._x) + beyond * np.cos(yaw)
        y = np.interp(arc, self._arc, self._y) + beyond * np.sin(yaw)
        return np.stack((x, y, yaw), axis=1)


class OtherPaths:
    """The paths of all other actors, each extended straight beyond its last sample.

    Args:
        others: Samples of the actors.
    """

    def __init__(self, others: ActorSamples) -> None:
        order = np.lexsort((others.samples, others.actors.ids))
        self._poses = others.actors.poses[order]
        ids = others.actors.ids[order]
        has_next = np.append(ids[1:] == ids[:-1], False)[: len(ids)]
        step = np.diff(self._poses, axis=0, append=self._poses[-1:]) * has_next[:, None]
        step[:, 2] = wrap_angles(step[:, 2])
        self._step = step
        self._length = np.hypot(step[:, 0], step[:, 1])
        self._arc = np.concatenate(([0.0], np.cumsum(self._length)[:-1]))[: len(ids)]
        last = np.flatnonzero(~has_next)
        self._last = last[np.searchsorted(last, np.arange(len(ids)))]
        self._row = np.empty(len(ids), np.int64)
        self._row[order] = np.arange(len(ids))
        self._speeds = others.actors.speeds

    def ahead(
        self, rows: Int[np.ndarray, " actors"], times: Float[np.ndarray, " actors"]
    ) -> Float[np.ndarray, "actors 3"]:
        """Return the poses `times` seconds after the samples, at the speed of each sample."""
        start = self._row[rows]
        arc = self._arc[start] + self._speeds[rows] * times
        at = np.searchsorted(self._arc, arc, side="right") - 1
        at = np.clip(at, start, self._last[start])
        rest, length = arc - self._arc[at], self._length[at]
        poses = self._poses[at] + self._step[at] * _share(rest, length)[:, None]
        straight = np.where(at == self._last[start], rest, 0.0)
        poses[:, 0] += straight * np.cos(poses[:, 2])
        poses[:, 1] += straight * np.sin(poses[:, 2])
        return poses


def _share(
    part: Float[np.ndarray, " actors"], whole: Float[np.ndarray, " actors"]
) -> Float[np.ndarray, " actors"]:
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0)


def followers(trajectory: Trajectory, others: ActorSamples) -> Bool[np.ndarray, " actors"]:
    """Return a mask of the actors that follow the ego: behind it, heading the same way."""
    poses, ego = others.actors.poses, trajectory.sample_poses[others.samples]
    x, y = poses[:, 0] - ego[:, 0], poses[:, 1] - ego[:, 1]
    behind = x * np.cos(ego[:, 2]) + y * np.sin(ego[:, 2]) < 0.0
    return behind & (np.cos(poses[:, 2] - ego[:, 2]) > SAME_DIRECTION)
