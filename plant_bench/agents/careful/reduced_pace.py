"""A conservative rollout of the ego: slower before speed limits and behind the leader."""

import math

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.agents.idm import IDM_ACCELERATION
from plant_bench.features.rollouts import STEP
from plant_bench.jit import F64, F64_1D, compiled
from plant_bench.world.driver_braking import CURVE_BRAKING

SLOWER = 0.85  # share of the allowed speed and acceleration that the ego reaches at least
MIN_SPEED = 0.1  # m/s


def reduced_travel(
    travel: Float[np.ndarray, " steps"],
    speed: float,
    route: RouteAhead,
    gap: float,
    leader_speed: float,
) -> Float[np.ndarray, " steps"]:
    """Return a rollout that stays below the speed limits ahead and behind the leader.

    Args:
        travel: The rollout: distance travelled at each instant, metres.
        speed: The ego's speed, m/s.
        route: The route ahead.
        gap: Distance until the ego would stop behind its leader, metres; infinite without one.
        leader_speed: The leader's speed, assumed constant, m/s.
    """
    limits, square = route.speed_limits, speed**2
    bounds = np.array((square, SLOWER, 2.0 * SLOWER * IDM_ACCELERATION, 2.0 * CURVE_BRAKING))
    return _slower(travel, limits, route.past, bounds, gap, leader_speed, STEP)


@compiled(F64_1D, F64_1D, F64, F64_1D, F64, F64, F64)
def _slower(travel, limits, past, bounds, gap, leader_speed, interval):
    """Return the least of a rollout, the travel that meets all limits, and the leader's."""
    square, share, doubled_acceleration, doubled_braking = bounds
    count = len(limits)
    reached, times, places = np.empty(count), np.zeros(count), np.empty(count)
    allowed = np.inf
    for place in range(count - 1, -1, -1):
        slope = doubled_braking * place
        allowed = min(allowed, limits[place] * limits[place] + slope)
        places[place] = max(place - past, 0.0)
        gained = square + doubled_acceleration * places[place]
        reached[place] = math.sqrt(min(gained, share * share * (allowed - slope)))
    for place in range(1, count):
        mean = max(0.5 * (reached[place] + reached[place - 1]), MIN_SPEED)
        times[place] = times[place - 1] + (places[place] - places[place - 1]) / mean
    slow, at = np.empty(len(travel)), 0
    for step in range(len(travel)):
        time = step * interval
        while at < count - 1 and times[at + 1] <= time:
            at += 1
        distance = places[at]
        if at < count - 1 and times[at] != time:  # as numpy.interp
            rate = (places[at + 1] - places[at]) / (times[at + 1] - times[at])
            distance = rate * (time - times[at]) + places[at]
        slow[step] = min(travel[step], distance)
        if gap < np.inf:
            slow[step] = min(slow[step], max(gap, 0.0) + leader_speed * time)
    return slow
