"""Finds the leader: the nearest actor in the ego's corridor along the route."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from plant_bench.agent import RouteAhead
from plant_bench.jit import F32_1D, F32_2D, F64, F64_1D, F64_2D, compiled
from plant_bench.world.scene import EGO_WIDTH, Actors

CLEARANCE = 0.3  # m on each side of the ego that belong to its corridor
MIN_VIEW = 25.0  # m of route ahead that are searched, plus
VIEW_TIME = 5.0  # s at the ego's speed
NEAR = 3.0  # m beside the route that a box must come within to be in the corridor
CROSSING_ANGLE = 0.7  # rad to the route above which a moving actor crosses rather than leads
CROSSING_SPEED = 1.5  # m/s above which it does


class Leader(NamedTuple):
    """An actor on the route ahead.

    Attributes:
        actor: Its row in the observation's actors; -1 for none.
        distance: Distance along the route from the ego's centre to its nearest corner, metres.
        speed: Its speed along the route, m/s, not below 0.
    """

    actor: int
    distance: float
    speed: float


NO_LEADER = Leader(-1, math.inf, 0.0)


class Corridor(NamedTuple):
    """The actors' positions relative to the ego's corridor along the route.

    Attributes:
        inside: Which actors are in the corridor, ahead of the ego's centre.
        crossing: Which actors cross the route rather than follow it.
        nearest: Distance along the route to the nearest corner inside, metres; infinite for actors
            outside.
        speeds: Speeds along the route, m/s.
        aside: Distance of each actor's centre from the nearest route point ahead, metres.
    """

    inside: Bool[np.ndarray, " actors"]
    crossing: Bool[np.ndarray, " actors"]
    nearest: Float[np.ndarray, " actors"]
    speeds: Float[np.ndarray, " actors"]
    aside: Float[np.ndarray, " actors"]

    def leader(self) -> Leader:
        """Return the nearest actor in the corridor that does not cross it."""
        distance = np.where(self.inside & ~self.crossing, self.nearest, math.inf)
        if not distance.size:
            return NO_LEADER
        index = int(np.argmin(distance))
        if distance[index] == math.inf:
            return NO_LEADER
        return Leader(index, float(distance[index]), float(self.speeds[index]))


def corridor(route: RouteAhead, actors: Actors, past: float, speed: float) -> Corridor:
    """Return the actors' positions relative to the ego's corridor.

    Args:
        route: The route ahead.
        actors: All other actors.
        past: Distance from the route's first point to the ego's centre, metres.
        speed: The ego's speed, m/s.
    """
    steps = int(MIN_VIEW + VIEW_TIME * speed)
    return Corridor(
        *_corridor(
            route.points[:steps],
            route.headings,
            actors.poses,
            actors.extents,
            actors.speeds,
            past,
            0.5 * EGO_WIDTH + CLEARANCE,
        )
    )


@compiled(F64_2D, F64, F64)
def _nearest(line, x, y):
    """Return the index of a polyline's nearest point, and the squared distance."""
    least, place = np.inf, 0
    for index in range(len(line)):
        dx, dy = x - line[index, 0], y - line[index, 1]
        square = dx * dx + dy * dy
        if square < least:
            least, place = square, index
    return place, least


@compiled(F64_2D, F64_1D, F32_1D, F32_1D, F64, F64)
def _distance(line, headings, pose, extent, past, half_width):
    """Return the distance along the corridor to a box inside it, metres; infinite if outside."""
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
    if all_ahead and right < 0.0 < left and closest < NEAR:  # the box spans the route
        return nearest - past
    return nearest_beside - past


@compiled(F64_2D, F64_1D, F32_2D, F32_2D, F32_1D, F64, F64)
def _corridor(line, headings, poses, extents, speeds, past, half_width):
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
