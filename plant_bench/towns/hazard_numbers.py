"""Draws hazard parameters that depend on the place; the table's `numbers` names functions here.

Each is given the place and a draw, and returns parameters, SI units, named as the kind's script
names them; None if the hazard would be unavoidable.
"""

import random

from plant_bench.towns.hazard_places import Place
from plant_bench.world.crossing_distance import (
    FARTHEST_START,
    RIDER_LENGTH,
    SPEED_SPREAD,
    WALKER_LENGTH,
    meets_at,
    needed_start,
)
from plant_bench.world.scene import WHEELBASE

CARS, CAR_ROOM = (3, 6), 7.6  # of a queue; m that each takes
CRAWLING, CRAWL = 0.4, (1.0, 2.0)  # share of queues that crawl; m/s

# A walker or rider
KERB_LEFT = 5.3  # m beside the path: behind the oncoming lane
WALKING, RIDING = (1.0, 2.0), (2.0, 4.0)  # m/s
RUNNING = 2.8  # m/s of a pedestrian that runs across from the left
RIDERS, HIDDEN, FROM_LEFT = 0.3, 0.4, 0.3  # shares of crossings

# Control loss: the metres aside that hands off the wheel would leave; the pull follows from them.
ASIDE = (1.6, 2.8)  # m
SLIP_TIME = (1.5, 2.5)  # s
HARDEST_PULL = 0.12  # rad


def slip(place: Place, draw: random.Random) -> dict[str, float]:
    """How long and hard the wheels are pulled: a sine that would leave the ego so far aside."""
    duration = draw.uniform(*SLIP_TIME)
    travelled = place.limit * duration
    pull = 6.2832 * WHEELBASE * draw.uniform(*ASIDE) / travelled**2
    return {"duration": duration, "pull": min(pull, HARDEST_PULL)}


def queue(place: Place, draw: random.Random) -> dict[str, float]:
    """How many cars, no more than fit on the lane, and how fast they crawl."""
    cars = draw.randint(CARS[0], max(min(CARS[1], int(place.room / CAR_ROOM)), CARS[0]))
    return {"cars": float(cars), "speed": draw.uniform(*CRAWL) if draw.random() < CRAWLING else 0.0}


def crossing(place: Place, draw: random.Random) -> dict[str, float] | None:
    """Who crosses, from where and how fast; some from the right behind a parked van."""
    return _crossing(place, draw, hidden=HIDDEN)


def open_crossing(place: Place, draw: random.Random) -> dict[str, float] | None:
    """As `crossing`, without a van."""
    return _crossing(place, draw, hidden=0.0)


def _crossing(place: Place, draw: random.Random, *, hidden: float) -> dict[str, float] | None:
    """Draw a crossing; None where all would be too fast to be avoided."""
    side = 1 if 1 in place.sides and draw.random() < FROM_LEFT else -1
    rider = draw.random() < RIDERS
    behind = hidden > 0.0 and side < 0 and draw.random() < hidden
    for who in (rider, not rider):
        low, high = crossing_speeds(place.limit, rider=who, side=side)
        if low <= high:
            speed = draw.uniform(low, high)
            return {"speed": speed, "side": side, "rider": float(who), "hidden": float(behind)}
    return None


def crossing_speeds(limit: float, *, rider: bool, side: int) -> tuple[float, float]:
    """Return the least and the greatest speed of a survivable crossing, m/s.

    From the left one starts behind the oncoming lane, hence not too slowly.
    """
    length = RIDER_LENGTH if rider else WALKER_LENGTH
    meets = meets_at(length)
    unit = needed_start(1.0, limit, length) - meets
    low, high = RIDING if rider else WALKING
    if side > 0:
        low = max(low, (KERB_LEFT - meets) / (unit * (1.0 - SPEED_SPREAD)))
        high = max(high, RUNNING)
    return low, min(high, (FARTHEST_START - meets) / (unit * (1.0 + SPEED_SPREAD)))
