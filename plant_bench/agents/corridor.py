"""Who is in the way: the nearest actor on the route ahead."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.agent import RouteAhead
from plant_bench.geometry.box import corners
from plant_bench.world.scene import EGO_WIDTH, Actors

CLEARANCE = 0.3  # m beside the ego that belongs to its corridor
CROSSING_ANGLE = 0.7  # rad to the route from which a moving actor crosses rather than leads
CROSSING_SPEED = 1.5  # m/s


class Leader(NamedTuple):
    """An actor on the route ahead.

    Attributes:
        index: Its place in the observation's actors; -1 for none.
        distance: Metres along the route from the ego's centre to its nearest corner.
        speed: m/s along the route, not below 0.
    """

    index: int
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
    """

    inside: Bool[np.ndarray, " actors"]
    crossing: Bool[np.ndarray, " actors"]
    nearest: Float[np.ndarray, " actors"]
    speeds: Float[np.ndarray, " actors"]

    def leader(self) -> Leader:
        """Return the nearest actor that stands or drives in the corridor and does not cross it."""
        distance = np.where(self.inside & ~self.crossing, self.nearest, math.inf)
        if not distance.size:
            return NO_LEADER
        index = int(np.argmin(distance))
        if distance[index] == math.inf:
            return NO_LEADER
        return Leader(index, float(distance[index]), float(self.speeds[index]))


def corridor(route: RouteAhead, actors: Actors, past: float) -> Corridor:
    """Hold the actors' boxes against the route ahead.

    Args:
        route: The route ahead.
        actors: All others.
        past: Metres from the route's first point to the ego's centre.
    """
    poses = actors.poses.astype(float)
    points = np.concatenate(
        (corners(poses, actors.extents.astype(float)), poses[:, None, :2]), axis=1
    )
    line = route.points
    dx = points[..., 0, None] - line[:, 0]
    dy = points[..., 1, None] - line[:, 1]
    nearest = np.argmin(dx * dx + dy * dy, axis=2)
    rows = np.ix_(range(points.shape[0]), range(points.shape[1]))
    cos, sin = np.cos(route.headings)[nearest], np.sin(route.headings)[nearest]
    dx, dy = dx[(*rows, nearest)], dy[(*rows, nearest)]
    along = nearest + cos * dx + sin * dy
    aside = cos * dy - sin * dx
    beyond = (along > len(line)) | (along < past)
    half = 0.5 * EGO_WIDTH + CLEARANCE
    near = (np.abs(aside) < half) & ~beyond
    straddles = (aside.min(axis=1) < 0.0) & (aside.max(axis=1) > 0.0) & ~beyond.any(axis=1)
    straddles &= np.abs(aside).min(axis=1) < 3.0
    inside = near.any(axis=1) | straddles
    reach = np.where(near | straddles[:, None], along, math.inf).min(axis=1) - past
    turn = poses[:, 2] - route.headings[nearest[:, 4]]
    speeds = actors.speeds * np.maximum(np.cos(turn), 0.0)
    crossing = (np.abs(np.sin(turn)) > math.sin(CROSSING_ANGLE)) & (actors.speeds > CROSSING_SPEED)
    return Corridor(inside, crossing, np.where(inside, reach, math.inf), speeds)
