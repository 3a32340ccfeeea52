"""Who is in the way: the nearest actor on the route ahead."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.agent import RouteAhead
from plant_bench.jit import REAL, REALS, REALS_2D, SINGLES, SINGLES_2D, compiled
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
    steps = int(LEAST_VIEW + VIEW_TIME * speed)
    return Corridor(
        *_hold(
            route.points[:steps],
            route.headings,
            actors.poses,
            actors.extents,
            actors.speeds,
            past,
            0.5 * EGO_WIDTH + CLEARANCE,
        )
    )


@compiled(REALS_2D, REAL, REAL)
def _nearest(line, x, y):
    """Return which point of a line is the nearest, and the square of the distance."""
    least, place = np.inf, 0
    for index in range(len(line)):
        dx, dy = x - line[index, 0], y - line[index, 1]
        square = dx * dx + dy * dy
        if square < least:
            least, place = square, index
    return place, least


@compiled(REALS_2D, REALS, SINGLES, SINGLES, REAL, REAL)
def _distance(line, headings, pose, extent, past, half_width):
    """Return how far a box that stands in the corridor ahead is along it; infinite for others."""
    x, y, yaw = np.float64(pose[0]), np.float64(pose[1]), np.float64(pose[2])
    length, width = np.float64(extent[0]), np.float64(extent[1])
    cos_box, sin_box = math.cos(yaw), math.sin(yaw)
    nearest, nearest_beside = np.inf, np.inf
    left, right, closest, all_ahead = -np.inf, np.inf, np.inf, True
    for corner in range(5):  # counter-clockwise from front left, and the centre
        long, wide = 0.0, 0.0
        if corner < 4:
            long = length * (0.5 if corner in (0, 3) else -0.5)
            wide = width * (0.5 if corner < 2 else -0.5)
        point_x = x + cos_box * long - sin_box * wide
        point_y = y + sin_box * long + cos_box * wide
        place, _ = _nearest(line, point_x, point_y)
        dx, dy = point_x - line[place, 0], point_y - line[place, 1]
        cos, sin = math.cos(headings[place]), math.sin(headings[place])
        along, aside = place + cos * dx + sin * dy, cos * dy - sin * dx
        ahead = past <= along <= len(line)
        if ahead and abs(aside) < half_width:
            nearest_beside = min(nearest_beside, along)
        nearest, closest = min(nearest, along), min(closest, abs(aside))
        left, right, all_ahead = max(left, aside), min(right, aside), all_ahead and ahead
    if all_ahead and right < 0.0 < left and closest < NEAR:  # it stands across the route
        return nearest - past
    return nearest_beside - past


@compiled(REALS_2D, REALS, SINGLES_2D, SINGLES_2D, SINGLES, REAL, REAL)
def _hold(line, headings, poses, extents, speeds, past, half_width):
    """Return a corridor's arrays."""
    count = len(poses)
    inside, crossing = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    reach, along_speeds, asides = np.full(count, np.inf), np.zeros(count), np.empty(count)
    for row in range(count):
        place, square = _nearest(line, poses[row, 0], poses[row, 1])
        asides[row] = math.sqrt(square)
        if not asides[row] < np.float32(0.5) * extents[row, 0] + np.float32(NEAR):
            continue
        turn, speed = poses[row, 2] - headings[place], np.float64(speeds[row])
        along_speeds[row] = speed * max(math.cos(turn), 0.0)
        crossing[row] = abs(math.sin(turn)) > math.sin(CROSSING_ANGLE) and speed > CROSSING_SPEED
        distance = _distance(line, headings, poses[row], extents[row], past, half_width)
        inside[row], reach[row] = distance < np.inf, distance
    return inside, crossing, reach, along_speeds, asides
