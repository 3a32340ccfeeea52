"""Where the ego itself may be: each choice of acceleration, and a slower pace."""

import math

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.agents.control import IDM_ACCELERATION
from plant_bench.agents.forecast import STEP, STEPS, TIMES
from plant_bench.features.inputs import CURVE_BRAKING

SLOWER = 0.85  # share of its pace that the ego surely reaches
LEAST_PACE = 0.1  # m/s


def rollout(
    speed: float, accelerations: Float[np.ndarray, " choices"], top: float
) -> Float[np.ndarray, "choices steps"]:
    """Return how far each constant acceleration gets, between standing and a top speed."""
    speeds = np.clip(speed + accelerations[:, None] * TIMES, 0.0, max(top, speed))
    travel = np.zeros((len(accelerations), STEPS))
    np.cumsum(0.5 * STEP * (speeds[:, 1:] + speeds[:, :-1]), axis=1, out=travel[:, 1:])
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
    slow = np.minimum(travel, _pace(speed, route))
    if room < math.inf:
        slow = np.minimum(slow, max(room, 0.0) + leader_speed * TIMES)
    return slow


def ego_poses(
    route: RouteAhead, travel: Float[np.ndarray, "*choices steps"]
) -> Float[np.ndarray, "*choices steps 3"]:
    """Return the ego's poses on the route after the given distances."""
    place = np.minimum(route.past + travel, len(route.points) - 1.001)
    index = place.astype(np.intp)
    share = (place - index)[..., None]
    points = route.points[index]
    points = points + share * (route.points[index + 1] - points)
    return np.concatenate((points, route.headings[index][..., None]), axis=-1)


def _pace(speed: float, route: RouteAhead) -> Float[np.ndarray, " steps"]:
    """Return how far the ego surely gets on a free road, meeting all limits ahead."""
    places = np.arange(len(route.speed_limits), dtype=float)
    slope = 2.0 * CURVE_BRAKING * places
    allowed = np.minimum.accumulate((route.speed_limits**2 + slope)[::-1])[::-1] - slope
    places = np.maximum(places - route.past, 0.0)
    gained = speed**2 + 2.0 * SLOWER * IDM_ACCELERATION * places
    reached = np.sqrt(np.minimum(gained, SLOWER**2 * allowed))
    mean = np.maximum(0.5 * (reached[1:] + reached[:-1]), LEAST_PACE)
    times = np.zeros(len(places))
    np.cumsum((places[1:] - places[:-1]) / mean, out=times[1:])
    return np.interp(TIMES, times, places)
