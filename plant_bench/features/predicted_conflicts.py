"""Token attributes of the predicted conflict of an actor and the route: a distance, three times.

Without them, a network has to learn which of the actors will be on its route, which takes more data
and training time than is practical on a small machine. No privileged inputs are used: only
positions, headings, speeds and rates of the actors, not their actual future motion.
"""

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import RouteAhead
from plant_bench.features.motion import Rates
from plant_bench.jit import (
    F32,
    F32_1D,
    F32_2D,
    F64_1D,
    F64_2D,
    INT64_1D,
    NEW_F32_2D,
    compiled,
)
from plant_bench.world.scene import EGO_WIDTH, Actors, EgoState

CONFLICT_ATTRIBUTES = 4
STEP, INSTANTS = 0.5, 13  # s between instants, and their number: six seconds
SPACING, VIEW = 2, 80  # m between the route points that are used, and m to the last of them
MARGIN = 0.8  # m between ego and actor boxes below which they conflict
NEVER = STEP * INSTANTS  # s, in place of a time if there is no conflict
MIN_EGO_SPEED = 1.0  # m/s, assumed for the ego's arrival time
MAX_ARRIVAL = 10.0  # s
MIN_ACCELERATION, MAX_ACCELERATION = -6.0, 3.0  # m/s2, bounds of an actor's assumed acceleration
MAX_SPEED = 15.0  # m/s, up to which an actor is assumed to accelerate
MAX_TURN = 0.5 * np.pi  # rad, by which an actor is assumed to turn at most


def predicted_conflicts(
    ego: EgoState,
    actors: Actors,
    places: Int[np.ndarray, " tokens"],
    route: RouteAhead,
    rates: Rates,
) -> Float[np.ndarray, "tokens 4"]:
    """Return where and when actors conflict with the route at constant acceleration and turn rate.

    Args:
        ego: The ego.
        actors: All actors.
        places: Rows of the actors to predict.
        route: The route ahead.
        rates: The actors' accelerations and turn rates; at zero they go straight on at their
            speeds.

    Returns:
        Distance along the route to the first conflict, at most `VIEW` metres; time until the actor
        enters and until it leaves the route, at most `NEVER` seconds; time until the ego is there
        at its present speed, at most `MAX_ARRIVAL` seconds. The maximum values if there is no
        conflict.
    """
    yaws, ahead = _extrapolate(
        actors.poses, actors.speeds, rates.accelerations, rates.turns, places
    )
    return _conflicts(
        np.array((ego.x, ego.y, ego.speed, route.past, EGO_WIDTH)),
        actors.poses,
        actors.extents,
        places,
        route.points,
        np.cos(yaws),  # numpy's float32 cosine, which differs from the C library's
        np.sin(yaws),
        ahead,
    )


@compiled(F32_2D, F32_1D, F32_1D, F32_1D, INT64_1D)
def _extrapolate(poses, speeds, accelerations, turns, places):
    """Return each actor's yaw at the instants, and the distance it covers between them."""
    single = np.float32
    yaws = np.empty((len(places), INSTANTS), single)
    ahead = np.empty((len(places), INSTANTS - 1), single)
    for row in range(len(places)):
        actor = places[row]
        speed = last = speeds[actor]
        acceleration = min(
            max(accelerations[actor], single(MIN_ACCELERATION)), single(MAX_ACCELERATION)
        )
        top = max(speed, single(MAX_SPEED))
        for instant in range(INSTANTS):
            time = single(instant) * single(STEP)
            reached = min(max(speed + acceleration * time, single(0.0)), top)
            turned = min(max(turns[actor] * time, single(-MAX_TURN)), single(MAX_TURN))
            yaws[row, instant] = poses[actor, 2] + turned
            if instant:
                ahead[row, instant - 1] = single(0.5 * STEP) * (reached + last)
            last = reached
    return yaws, ahead


@compiled(NEW_F32_2D, F32, F32, F32, F32, F32, F32)
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


@compiled(F64_1D, F32_2D, F32_2D, INT64_1D, F64_2D, F32_2D, F32_2D, F32_2D)
def _conflicts(ego, poses, extents, places, route, cos, sin, ahead):
    """Return the attributes that `predicted_conflicts` documents."""
    single = np.float32
    ego_x, ego_y, ego_speed, past, ego_width = ego
    found = np.empty((len(places), CONFLICT_ATTRIBUTES), single)
    points = np.empty((2, (min(len(route), VIEW + 1) + SPACING - 1) // SPACING), single)
    for point in range(points.shape[1]):
        points[0, point] = route[SPACING * point, 0] - ego_x
        points[1, point] = route[SPACING * point, 1] - ego_y
    x, y = np.empty(INSTANTS, single), np.empty(INSTANTS, single)
    for row in range(len(places)):
        found[row, 0], found[row, 1], found[row, 2], found[row, 3] = VIEW, NEVER, NEVER, MAX_ARRIVAL
        actor = places[row]
        length = extents[actor, 0]
        reach = single(0.5) * (single(ego_width) + extents[actor, 1]) + single(MARGIN)
        moved_x = moved_y = single(0.0)
        first, place = -1, -1
        for instant in range(INSTANTS):
            if instant:
                step = ahead[row, instant - 1]
                moved_x += single(0.5) * (cos[row, instant] + cos[row, instant - 1]) * step
                moved_y += single(0.5) * (sin[row, instant] + sin[row, instant - 1]) * step
            x[instant] = moved_x + (poses[actor, 0] - single(ego_x))
            y[instant] = moved_y + (poses[actor, 1] - single(ego_y))
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
        found[row, 3] = min(along / max(ego_speed, MIN_EGO_SPEED), MAX_ARRIVAL)
    return found
