"""Where and when others, going on as they do, get into the ego's way: four more attributes.

A network has to find out by itself which of the boxes around it will be on its route, which takes
more data and training than a small machine has. Nothing here is privileged: place, heading and
speed of the actors are all there is in it, and what they will really do is not.
"""

import numpy as np
from jaxtyping import Bool, Float, Int

from plant_bench.agent import RouteAhead
from plant_bench.features.tracks import Rates
from plant_bench.world.scene import EGO_WIDTH, Actors, EgoState

MEETING_ATTRIBUTES = 4
STEP, INSTANTS = 0.5, 13  # s, and how many: six seconds
SPACING, VIEW = 2, 80  # m between route points looked at, and how far they reach
MARGIN = 0.8  # m between the boxes at which somebody is in the way
NEVER = STEP * INSTANTS  # s
SLOWEST = 1.0  # m/s, of the ego on its way there
LATEST = 10.0  # s
HARDEST, FIRMEST = -6.0, 3.0  # m/s2 that others are believed to go on with
FASTEST = 15.0  # m/s up to which they are believed to speed up
WIDEST = 0.5 * np.pi  # rad that they are believed to turn

_TIMES = np.arange(INSTANTS, dtype=np.float32) * STEP
_PARTS = np.array([-0.5, 0.0, 0.5], np.float32)  # rear, centre and front, in lengths


def meetings(
    ego: EgoState,
    actors: Actors,
    places: Int[np.ndarray, " tokens"],
    route: RouteAhead,
    rates: Rates,
) -> Float[np.ndarray, "tokens 4"]:
    """Return where and when some actors get into the ego's way if they go on as they do.

    Args:
        ego: The ego.
        actors: All actors.
        places: Of those wanted.
        route: The route ahead.
        rates: How the actors change; without any they go straight on at their speeds.

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
    near = _near(ego, actors, places, points, rates)
    when = np.any(near, axis=2)
    who = np.flatnonzero(np.any(when, axis=1))
    first = when[who].argmax(axis=1)
    last = INSTANTS - 1 - when[who, ::-1].argmax(axis=1)
    there = near[who, first].argmax(axis=1) * float(SPACING) - route.past
    along = np.maximum(there, 0.0)
    found[who, 0] = along
    found[who, 1] = first * STEP
    found[who, 2] = (last + 1) * STEP
    found[who, 3] = np.minimum(along / max(ego.speed, SLOWEST), LATEST)
    return found


def _near(
    ego: EgoState, actors: Actors, places: np.ndarray, points: np.ndarray, rates: Rates
) -> Bool[np.ndarray, "tokens instants points"]:
    """Return which actors at which instants are near which route points."""
    poses = actors.poses[places]
    lengths, widths = actors.extents[places].T
    yaws, ahead = _goings(poses[:, 2], actors.speeds[places], rates, places)
    cos, sin = np.cos(yaws), np.sin(yaws)
    x = np.zeros_like(yaws)
    y = np.zeros_like(yaws)
    np.cumsum(0.5 * (cos[:, 1:] + cos[:, :-1]) * ahead, axis=1, out=x[:, 1:])
    np.cumsum(0.5 * (sin[:, 1:] + sin[:, :-1]) * ahead, axis=1, out=y[:, 1:])
    x += (poses[:, 0] - np.float32(ego.x))[:, None]
    y += (poses[:, 1] - np.float32(ego.y))[:, None]
    parts = lengths[:, None, None] * _PARTS
    all_x = x[..., None] + parts * cos[..., None]
    all_y = y[..., None] + parts * sin[..., None]
    squares = (all_x[..., None] - points[:, 0]) ** 2 + (all_y[..., None] - points[:, 1]) ** 2
    reach = 0.5 * (EGO_WIDTH + widths) + MARGIN
    return np.any(squares < (reach * reach)[:, None, None, None], axis=2)


def _goings(
    yaws: np.ndarray, speeds: np.ndarray, rates: Rates, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return each actor's yaw at the instants, and how far it gets between them."""
    pulls = rates.accelerations[places].clip(HARDEST, FIRMEST)
    tops = np.maximum(speeds, np.float32(FASTEST))
    paces = (speeds[:, None] + pulls[:, None] * _TIMES).clip(0.0, tops[:, None])
    turned = (rates.turns[places, None] * _TIMES).clip(-WIDEST, WIDEST)
    ahead = 0.5 * STEP * (paces[:, 1:] + paces[:, :-1])
    return (yaws[:, None] + turned).astype(np.float32), ahead.astype(np.float32)
