"""A slower pace than a rollout's: one that the ego surely reaches."""

import math

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.agents.idm import IDM_ACCELERATION
from plant_bench.features.rollouts import STEP
from plant_bench.jit import REAL, REALS, compiled
from plant_bench.world.driver_braking import CURVE_BRAKING

SLOWER = 0.85  # share of its pace that the ego surely reaches
LEAST_PACE = 0.1  # m/s


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
