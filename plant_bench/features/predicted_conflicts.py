"""Where and when others, going on as they do, get into the ego's way: four more attributes.

A network has to find out by itself which of the boxes around it will be on its route, which takes
more data and training than a small machine has. Nothing here is privileged: place, heading and
speed of the actors are all there is in it, and what they will really do is not.
"""

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import RouteAhead
from plant_bench.features.motion import Rates
from plant_bench.jit import (
    NEW_SINGLES_2D,
    REALS,
    REALS_2D,
    SINGLE,
    SINGLES,
    SINGLES_2D,
    WHOLES,
    compiled,
)
from plant_bench.world.scene import EGO_WIDTH, Actors, EgoState

CONFLICT_ATTRIBUTES = 4
STEP, INSTANTS = 0.5, 13  # s, and how many: six seconds
SPACING, VIEW = 2, 80  # m between route points looked at, and how far they reach
MARGIN = 0.8  # m between the boxes at which somebody is in the way
NEVER = STEP * INSTANTS  # s
SLOWEST = 1.0  # m/s, of the ego on its way there
LATEST = 10.0  # s
HARDEST, FIRMEST = -6.0, 3.0  # m/s2 that others are believed to go on with
FASTEST = 15.0  # m/s up to which they are believed to speed up
WIDEST = 0.5 * np.pi  # rad that they are believed to turn


def predicted_conflicts(
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
    yaws, ahead = _goings(actors.poses, actors.speeds, rates.accelerations, rates.turns, places)
    return _meetings(
        np.array((ego.x, ego.y, ego.speed, route.past, EGO_WIDTH)),
        actors.poses,
        actors.extents,
        places,
        route.points,
        np.cos(yaws),  # of float32: numpy's own, which the C library's do not equal
        np.sin(yaws),
        ahead,
    )


@compiled(SINGLES_2D, SINGLES, SINGLES, SINGLES, WHOLES)
def _goings(poses, speeds, accelerations, turns, places):
    """Return each actor's yaw at the instants, and how far it gets between them."""
    single = np.float32
    yaws = np.empty((len(places), INSTANTS), single)
    ahead = np.empty((len(places), INSTANTS - 1), single)
    for row in range(len(places)):
        actor = places[row]
        speed = last = speeds[actor]
        pull = min(max(accelerations[actor], single(HARDEST)), single(FIRMEST))
        top = max(speed, single(FASTEST))
        for instant in range(INSTANTS):
            time = single(instant) * single(STEP)
            pace = min(max(speed + pull * time, single(0.0)), top)
            turned = min(max(turns[actor] * time, single(-WIDEST)), single(WIDEST))
            yaws[row, instant] = poses[actor, 2] + turned
            if instant:
                ahead[row, instant - 1] = single(0.5 * STEP) * (pace + last)
            last = pace
    return yaws, ahead


@compiled(NEW_SINGLES_2D, SINGLE, SINGLE, SINGLE, SINGLE, SINGLE, SINGLE)
def _first_near(points, x, y, cos, sin, length, square):
    """Return the first route point near an actor's rear, centre or front; -1 for none."""
    first = points.shape[1]
    for part in range(3):
        along = length * np.float32(0.5 * (part - 1))
        part_x, part_y = x + along * cos, y + along * sin
        for point in range(points.shape[1]):
            dx, dy = part_x - points[0, point], part_y - points[1, point]
            if dx * dx + dy * dy < square:
                first = min(first, point)
    return first if first < points.shape[1] else -1


@compiled(REALS, SINGLES_2D, SINGLES_2D, WHOLES, REALS_2D, SINGLES_2D, SINGLES_2D, SINGLES_2D)
def _meetings(ego, poses, extents, places, route, cos, sin, ahead):
    """Return what `predicted_conflicts` does."""
    single = np.float32
    ego_x, ego_y, ego_speed, past, ego_width = ego
    found = np.empty((len(places), CONFLICT_ATTRIBUTES), single)
    points = np.empty((2, (min(len(route), VIEW + 1) + SPACING - 1) // SPACING), single)
    for point in range(points.shape[1]):
        points[0, point] = route[SPACING * point, 0] - ego_x
        points[1, point] = route[SPACING * point, 1] - ego_y
    x, y = np.empty(INSTANTS, single), np.empty(INSTANTS, single)
    for row in range(len(places)):
        found[row, 0], found[row, 1], found[row, 2], found[row, 3] = VIEW, NEVER, NEVER, LATEST
        actor = places[row]
        length = extents[actor, 0]
        reach = single(0.5) * (single(ego_width) + extents[actor, 1]) + single(MARGIN)
        gone_x = gone_y = single(0.0)
        first, place = -1, -1
        for instant in range(INSTANTS):
            if instant:
                going = ahead[row, instant - 1]
                gone_x += single(0.5) * (cos[row, instant] + cos[row, instant - 1]) * going
                gone_y += single(0.5) * (sin[row, instant] + sin[row, instant - 1]) * going
            x[instant] = gone_x + (poses[actor, 0] - single(ego_x))
            y[instant] = gone_y + (poses[actor, 1] - single(ego_y))
            if place < 0:
                place = _first_near(
                    points, x[instant], y[instant], cos[row, instant], sin[row, instant],
                    length, reach * reach,
                )  # fmt: skip
                first = instant
        if place < 0:
            continue
        last = INSTANTS - 1
        while (
            last > first
            and _first_near(
                points, x[last], y[last], cos[row, last], sin[row, last], length, reach * reach
            )
            < 0
        ):
            last -= 1
        along = max(place * float(SPACING) - past, 0.0)
        found[row, 0], found[row, 1], found[row, 2] = along, first * STEP, (last + 1) * STEP
        found[row, 3] = min(along / max(ego_speed, SLOWEST), LATEST)
    return found
