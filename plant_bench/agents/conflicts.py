"""Which accelerations keep clear of the forecast boxes of others."""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.agents.forecast import STEP, STEPS, TIMES, Forecast
from plant_bench.geometry.box import overlap
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH

MARGIN_ALONG = 1.0  # m in front of and behind others
MARGIN_ASIDE = 0.25  # m on each side of others


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
) -> Float[np.ndarray, " choices"]:
    """Return for each choice the time of the first overlap, infinite for none.

    Args:
        poses: The ego's poses, one row a choice.
        forecast: The others.
        boldness: 0 keeps the full margins, 1 none towards who stands.
        caution: Share of the margins kept towards all.
    """
    times = np.full(len(poses), np.inf)
    share = caution * np.where(forecast.standing, 1.0 - boldness, 1.0)
    lengths = forecast.lengths + 2 * MARGIN_ALONG * share[:, None]
    widths = forecast.widths + 2 * MARGIN_ASIDE * share
    dx = poses[:, None, :, 0] - forecast.poses[None, :, :, 0]
    dy = poses[:, None, :, 1] - forecast.poses[None, :, :, 1]
    reach = 0.5 * (EGO_LENGTH + EGO_WIDTH + lengths + widths[:, None])
    near = np.nonzero(dx * dx + dy * dy < reach * reach)
    if not near[0].size:
        return times
    choice, actor, step = near
    ego_extents = np.broadcast_to(np.array(EGO_EXTENT), (len(choice), 2))
    extents = np.stack((lengths[actor, step], widths[actor]), axis=1)
    hits = overlap(poses[choice, step], ego_extents, forecast.poses[actor, step], extents)
    np.minimum.at(times, choice[hits], TIMES[step[hits]])
    return times
