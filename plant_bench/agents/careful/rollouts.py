"""Where the ego itself may be: each choice of acceleration, and a slower pace."""

import math

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.agents.careful.forecast import STEP, STEPS
from plant_bench.agents.idm import IDM_ACCELERATION
from plant_bench.compiled import REAL, REALS, REALS_2D, WHOLE, compiled
from plant_bench.world.braking import CURVE_BRAKING

SLOWER = 0.85  # share of its pace that the ego surely reaches
LEAST_PACE = 0.1  # m/s


def rollout(
    speed: float, accelerations: Float[np.ndarray, " choices"], top: float
) -> Float[np.ndarray, "choices steps"]:
    """Return how far each constant acceleration gets, between standing and a top speed."""
    return _rollout(speed, accelerations, max(top, speed), STEP, STEPS)


@compiled(REAL, REALS, REAL, REAL, WHOLE)
def _rollout(speed, accelerations, top, interval, steps):
    travel = np.zeros((len(accelerations), steps))
    for choice in range(len(accelerations)):
        last = min(max(speed + accelerations[choice] * 0.0, 0.0), top)
        for step in range(1, steps):
            reached = min(max(speed + accelerations[choice] * (step * interval), 0.0), top)
            travel[choice, step] = travel[choice, step - 1] + 0.5 * interval * (reached + last)
            last = reached
    return travel


def at_slower_pace(
    travel: Float[np.ndarray, " steps"],
    speed: float,
    route: RouteAhead,
    room: float,
    leader_speed: float,
) -> Float[np.ndarray, " steps"]:
    """Return a rollout that falls short of the speed limits ahead and stays behind the leader.

    Args:
        travel: The rollout, metres.
        speed: The ego's, m/s.
        route: The route ahead.
        room: Metres to where the ego would stand behind its leader now; infinite without one.
        leader_speed: m/s, at which it is taken to go on.
    """
    limits, square = route.speed_limits, speed**2
    pace = np.array((square, SLOWER, 2.0 * SLOWER * IDM_ACCELERATION, 2.0 * CURVE_BRAKING))
    return _slower(travel, limits, route.past, pace, room, leader_speed, STEP)


@compiled(REALS, REALS, REAL, REALS, REAL, REAL, REAL)
def _slower(travel, limits, past, pace, room, leader_speed, interval):
    """Return the lesser of a rollout, the pace that meets all limits ahead, and the leader's."""
    square, share, doubled_pull, doubled_braking = pace
    count = len(limits)
    reached, times, places = np.empty(count), np.zeros(count), np.empty(count)
    allowed = np.inf
    for place in range(count - 1, -1, -1):
        slope = doubled_braking * place
        allowed = min(allowed, limits[place] * limits[place] + slope)
        places[place] = max(place - past, 0.0)
        gained = square + doubled_pull * places[place]
        reached[place] = math.sqrt(min(gained, share * share * (allowed - slope)))
    for place in range(1, count):
        mean = max(0.5 * (reached[place] + reached[place - 1]), LEAST_PACE)
        times[place] = times[place - 1] + (places[place] - places[place - 1]) / mean
    slow, at = np.empty(len(travel)), 0
    for step in range(len(travel)):
        time = step * interval
        while at < count - 1 and times[at + 1] <= time:
            at += 1
        gone = places[at]
        if at < count - 1 and times[at] != time:  # as numpy.interp
            gain = (places[at + 1] - places[at]) / (times[at + 1] - times[at])
            gone = gain * (time - times[at]) + places[at]
        slow[step] = min(travel[step], gone)
        if room < np.inf:
            slow[step] = min(slow[step], max(room, 0.0) + leader_speed * time)
    return slow


def ego_poses(
    route: RouteAhead, travel: Float[np.ndarray, "choices steps"]
) -> Float[np.ndarray, "choices steps 3"]:
    """Return the ego's poses on the route after the given distances."""
    return _poses(route.points, route.headings, route.past, travel)


@compiled(REALS_2D, REALS, REAL, REALS_2D)
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
