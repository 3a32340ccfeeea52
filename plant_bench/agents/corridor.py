"""Who is in the way: the nearest actor on the route ahead."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.agent import RouteAhead
from plant_bench.geometry.box import corners
from plant_bench.world.scene import EGO_WIDTH, Actors

CLEARANCE = 0.3  # m beside the ego that belongs to its corridor
LEAST_VIEW = 25.0  # m of route ahead that are looked at, and
VIEW_TIME = 5.0  # s more at the ego's speed
NEAR = 3.0  # m from the route beyond which no part of a box can stand in the corridor
CROSSING_ANGLE = 0.7  # rad to the route from which a moving actor crosses rather than leads
CROSSING_SPEED = 1.5  # m/s


class Leader(NamedTuple):
    """An actor on the route ahead.

    Attributes:
        actor: Its place in the observation's actors; -1 for none.
        distance: Metres along the route from the ego's centre to its nearest corner.
        speed: m/s along the route, not below 0.
    """

    actor: int
    distance: float
    speed: float


NO_LEADER = Leader(-1, math.inf, 0.0)


class Corridor(NamedTuple):
    """The actors held against the route ahead.

    Attributes:
        inside: Which of them stand in the ego's corridor, ahead of its centre.
        crossing: Which of those only cross it.
        nearest: Metres along the route to the nearest corner inside; infinite outside.
        speeds: m/s along the route.
        aside: Metres from the route's points ahead to the centre of each.
    """

    inside: Bool[np.ndarray, " actors"]
    crossing: Bool[np.ndarray, " actors"]
    nearest: Float[np.ndarray, " actors"]
    speeds: Float[np.ndarray, " actors"]
    aside: Float[np.ndarray, " actors"]

    def leader(self) -> Leader:
        """Return the nearest actor that stands or drives in the corridor and does not cross it."""
        distance = np.where(self.inside & ~self.crossing, self.nearest, math.inf)
        if not distance.size:
            return NO_LEADER
        index = int(np.argmin(distance))
        if distance[index] == math.inf:
            return NO_LEADER
        return Leader(index, float(distance[index]), float(self.speeds[index]))


def corridor(route: RouteAhead, actors: Actors, past: float, speed: float) -> Corridor:
    """Hold the actors' boxes against the route ahead.

    Args:
        route: The route ahead.
        actors: All others.
        past: Metres from the route's first point to the ego's centre.
        speed: The ego's, m/s.
    """
    count = len(actors)
    inside, crossing = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    reach, speeds = np.full(count, math.inf), np.zeros(count)
    line = route.points[: int(LEAST_VIEW + VIEW_TIME * speed)]
    dx = actors.poses[:, 0, None] - line[:, 0]
    dy = actors.poses[:, 1, None] - line[:, 1]
    square = dx * dx + dy * dy
    aside = np.sqrt(square.min(axis=1))
    near = (aside < 0.5 * actors.extents[:, 0] + NEAR).nonzero()[0]
    if near.size:
        poses = actors.poses[near].astype(float)
        index = square[near].argmin(axis=1)
        turn = poses[:, 2] - route.headings[index]
        moving = actors.speeds[near].astype(float)
        extents = actors.extents[near].astype(float)
        inside[near], reach[near] = _hold(line, route.headings[: len(line)], poses, extents, past)
        speeds[near] = moving * np.maximum(np.cos(turn), 0.0)
        crosses = np.abs(np.sin(turn)) > math.sin(CROSSING_ANGLE)
        crossing[near] = crosses & (moving > CROSSING_SPEED)
    return Corridor(inside, crossing, reach, speeds, aside)


def _hold(
    line: Float[np.ndarray, "steps 2"],
    headings: Float[np.ndarray, " steps"],
    poses: Float[np.ndarray, "actors 3"],
    extents: Float[np.ndarray, "actors 2"],
    past: float,
) -> tuple[Bool[np.ndarray, " actors"], Float[np.ndarray, " actors"]]:
    """Return which boxes stand in the corridor ahead, and how far away their nearest corner is."""
    points = np.concatenate((corners(poses, extents), poses[:, None, :2]), axis=1)
    dx = points[..., 0, None] - line[:, 0]
    dy = points[..., 1, None] - line[:, 1]
    nearest = (dx * dx + dy * dy).argmin(axis=2)
    offset = points - line[nearest]
    cos, sin = np.cos(headings)[nearest], np.sin(headings)[nearest]
    along = nearest + cos * offset[..., 0] + sin * offset[..., 1]
    aside = cos * offset[..., 1] - sin * offset[..., 0]
    ahead = (along <= len(line)) & (along >= past)
    beside = (np.abs(aside) < 0.5 * EGO_WIDTH + CLEARANCE) & ahead
    astride = (aside.min(axis=1) < 0.0) & (aside.max(axis=1) > 0.0) & ahead.all(axis=1)
    astride &= np.abs(aside).min(axis=1) < NEAR
    distance = np.where(beside | astride[:, None], along, math.inf).min(axis=1) - past
    inside = beside.any(axis=1) | astride
    return inside, np.where(inside, distance, math.inf)
