"""Where and when others, going straight on, get into the ego's way: four more attributes.

A network has to find out by itself which of the boxes around it will be on its route, which takes
more data and training than a small machine has. Nothing here is privileged: place, heading and
speed of the actors are all there is in it, and what they will really do is not.
"""

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import RouteAhead
from plant_bench.world.scene import EGO_WIDTH, Actors, EgoState

MEETING_ATTRIBUTES = 4
STEP, INSTANTS = 0.5, 13  # s, and how many: six seconds
SPACING, VIEW = 2, 80  # m between route points looked at, and how far they reach
MARGIN = 0.8  # m between the boxes at which somebody is in the way
NEVER = STEP * INSTANTS  # s
SLOWEST = 1.0  # m/s, of the ego on its way there
LATEST = 10.0  # s

_TIMES = np.arange(INSTANTS, dtype=np.float32) * STEP
_PARTS = np.array([-0.5, 0.0, 0.5], np.float32)  # rear, centre and front, in lengths


def meetings(
    ego: EgoState, actors: Actors, places: Int[np.ndarray, " tokens"], route: RouteAhead
) -> Float[np.ndarray, "tokens 4"]:
    """Return where and when some actors get into the ego's way if they go straight on.

    Args:
        ego: The ego.
        actors: All actors.
        places: Of those wanted.
        route: The route ahead.

    Returns:
        Metres along the route to where an actor first gets in the way, at most `VIEW`; seconds
        until then and until it has left, at most `NEVER`; seconds until the ego is there at its
        present speed, at most `LATEST`. The greatest values for who never gets in the way.
    """
    found = np.empty((len(places), MEETING_ATTRIBUTES), np.float32)
    found[:] = VIEW, NEVER, NEVER, LATEST
    points = (route.points[: VIEW + 1 : SPACING] - (ego.x, ego.y)).astype(np.float32)
    if not len(places) or not len(points):
        return found
    near = _near(ego, actors, places, points)
    when = near.any(axis=2)
    who = when.any(axis=1).nonzero()[0]
    first = when[who].argmax(axis=1)
    last = INSTANTS - 1 - when[who, ::-1].argmax(axis=1)
    there = near[who, first].argmax(axis=1) * float(SPACING) - route.past
    along = np.maximum(there, 0.0)
    found[who, 0] = along
    found[who, 1] = first * STEP
    found[who, 2] = (last + 1) * STEP
    found[who, 3] = np.minimum(along / max(ego.speed, SLOWEST), LATEST)
    return found


def _near(ego: EgoState, actors: Actors, places: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return which actors at which instants are near which route points."""
    poses = actors.poses[places]
    lengths, widths = actors.extents[places].T
    ahead = actors.speeds[places, None] * _TIMES
    ahead = ahead[:, :, None] + lengths[:, None, None] * _PARTS
    x0, y0 = poses[:, 0] - np.float32(ego.x), poses[:, 1] - np.float32(ego.y)
    x = x0[:, None, None] + ahead * np.cos(poses[:, 2])[:, None, None]
    y = y0[:, None, None] + ahead * np.sin(poses[:, 2])[:, None, None]
    squares = (x[..., None] - points[:, 0]) ** 2 + (y[..., None] - points[:, 1]) ** 2
    reach = 0.5 * (EGO_WIDTH + widths) + MARGIN
    return (squares < (reach * reach)[:, None, None, None]).any(axis=2)
