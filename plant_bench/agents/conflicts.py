"""Which accelerations keep clear of the forecast boxes of others."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import RouteAhead
from plant_bench.agents.forecast import STEP, STEPS, TIMES, Forecast
from plant_bench.geometry.box import overlap
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH

MARGIN_ASIDE = 0.25  # m on each side of others


class Conflicts(NamedTuple):
    """The first overlap that each choice runs into.

    Attributes:
        times: Seconds; infinite for none.
        actors: Whose box it is, a row of the forecast; -1 for none.
    """

    times: Float[np.ndarray, " choices"]
    actors: Int[np.ndarray, " choices"]


def rollout(
    speed: float, accelerations: Float[np.ndarray, " choices"], top: Float[np.ndarray, " choices"]
) -> Float[np.ndarray, "choices steps"]:
    """Return how far each constant acceleration gets, between standing and a top speed."""
    speeds = np.clip(speed + accelerations[:, None] * TIMES, 0.0, np.maximum(top, speed)[:, None])
    travel = np.zeros((len(accelerations), STEPS))
    np.cumsum(0.5 * STEP * (speeds[:, 1:] + speeds[:, :-1]), axis=1, out=travel[:, 1:])
    return travel


def ego_poses(
    route: RouteAhead, past: float, travel: Float[np.ndarray, "choices steps"]
) -> Float[np.ndarray, "choices steps 3"]:
    """Return the ego's poses on the route after the given distances."""
    place = np.minimum(past + travel, len(route.points) - 1.001)
    index = place.astype(np.intp)
    share = (place - index)[..., None]
    points = route.points[index]
    points = points + share * (route.points[index + 1] - points)
    return np.concatenate((points, route.headings[index][..., None]), axis=2)


def first_conflicts(
    poses: Float[np.ndarray, "choices steps 3"],
    forecast: Forecast,
    boldness: float,
    caution: float = 1.0,
) -> Conflicts:
    """Return for each choice the first overlap; of several at once, the nearest box.

    Args:
        poses: The ego's poses, one row a choice.
        forecast: The others.
        boldness: 0 keeps the full margins, 1 none towards who stands.
        caution: Share of the margins kept towards all.
    """
    times, actors = np.full(len(poses), np.inf), np.full(len(poses), -1)
    share = caution * np.where(forecast.standing, 1.0 - boldness, 1.0)
    lengths = forecast.lengths + 2 * (forecast.margins * share)[:, None]
    widths = forecast.widths + 2 * MARGIN_ASIDE * share
    dx = poses[:, None, :, 0] - forecast.poses[None, :, :, 0]
    dy = poses[:, None, :, 1] - forecast.poses[None, :, :, 1]
    reach = 0.5 * (EGO_LENGTH + EGO_WIDTH + lengths + widths[:, None])
    square = dx * dx + dy * dy
    choice, actor, step = np.nonzero(square < reach * reach)
    if not choice.size:
        return Conflicts(times, actors)
    ego_extents = np.broadcast_to(np.array(EGO_EXTENT), (len(choice), 2))
    extents = np.stack((lengths[actor, step], widths[actor]), axis=1)
    hits = overlap(poses[choice, step], ego_extents, forecast.poses[actor, step], extents)
    choice, actor, step = choice[hits], actor[hits], step[hits]
    order = np.lexsort((square[choice, actor, step], step, choice))
    found, first = np.unique(choice[order], return_index=True)
    times[found] = TIMES[step[order][first]]
    actors[found] = actor[order][first]
    return Conflicts(times, actors)


def clearest(poses: np.ndarray, forecast: Forecast, boldness: float) -> int:
    """Return the first choice that is clear, else the one that is clear longest, else the last."""
    times = first_conflicts(poses, forecast, boldness).times
    if times.max() == 0.0:  # within the margins already: what matters is not to touch
        times = first_conflicts(poses, forecast, boldness, caution=0.0).times
    if times.max() > times.min() or times[0] == math.inf:
        return int(np.argmax(times))
    return len(times) - 1
