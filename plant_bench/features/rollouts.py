"""Rolls out constant accelerations along the route: travelled distances and ego poses."""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.jit import F64, F64_1D, F64_2D, INT64, compiled

STEP = 0.25  # s between two instants
STEPS = 28  # instants, from now to 6.75 s: enough to cross a large junction from standstill


def rollout(
    speed: float, accelerations: Float[np.ndarray, " choices"], top: float
) -> Float[np.ndarray, "choices steps"]:
    """Return the distance travelled at each instant for each acceleration, metres.

    Speeds are clipped to 0 and `top`.
    """
    return _rollout(speed, accelerations, max(top, speed), STEP, STEPS)


@compiled(F64, F64_1D, F64, F64, INT64)
def _rollout(speed, accelerations, top, interval, steps):
    travel = np.zeros((len(accelerations), steps))
    for choice in range(len(accelerations)):
        last = min(max(speed + accelerations[choice] * 0.0, 0.0), top)
        for step in range(1, steps):
            reached = min(max(speed + accelerations[choice] * (step * interval), 0.0), top)
            travel[choice, step] = travel[choice, step - 1] + 0.5 * interval * (reached + last)
            last = reached
    return travel


def ego_poses(
    route: RouteAhead, travel: Float[np.ndarray, "choices steps"]
) -> Float[np.ndarray, "choices steps 3"]:
    """Return the ego's poses on the route after the travelled distances."""
    return _poses(route.points, route.headings, route.past, travel)


@compiled(F64_2D, F64_1D, F64, F64_2D)
def _poses(points, headings, past, travel):
    poses = np.empty((travel.shape[0], travel.shape[1], 3))
    for row in range(travel.shape[0]):
        for step in range(travel.shape[1]):
            place = min(past + travel[row, step], len(points) - 1.001)
            index = int(place)
            share = place - index
            for axis in range(2):
                begin = points[index, axis]
                poses[row, step, axis] = begin + share * (points[index + 1, axis] - begin)
            poses[row, step, 2] = headings[index]
    return poses
