"""Draws the hazard parameters that depend on the place, such as speeds of pedestrians.

The `numbers` of the hazard table name functions in this module. Each gets the place and a random
generator, and returns the parameters of the hazard's behaviour by name, in SI units; None if the
hazard would be unavoidable.
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

CARS, CAR_SPACING = (3, 6), 7.6  # cars in a queue; m of lane per car
CRAWLING, CRAWL = 0.4, (1.0, 2.0)  # share of queues that crawl; m/s

# Crossing pedestrian or cyclist
KERB_LEFT = 5.3  # m beside the path: on the far side of the oncoming lane
WALKING, RIDING = (1.0, 2.0), (2.0, 4.0)  # m/s
RUNNING = 2.8  # m/s of a pedestrian that runs across from the left
RIDERS, HIDDEN, FROM_LEFT = 0.3, 0.4, 0.3  # shares of crossings

# Control loss: a steering disturbance, given by the lateral offset that it causes uncorrected
ASIDE = (1.6, 2.8)  # m
SLIP_TIME = (1.5, 2.5)  # s
MAX_PULL = 0.12  # rad


def slip(place: Place, draw: random.Random) -> dict[str, float]:
    """Draw a control loss: duration and amplitude (`pull`) of a sine added to the steering."""
    duration = draw.uniform(*SLIP_TIME)
    travelled = place.limit * duration
    pull = 6.2832 * WHEELBASE * draw.uniform(*ASIDE) / travelled**2
    return {"duration": duration, "pull": min(pull, MAX_PULL)}


def queue(place: Place, draw: random.Random) -> dict[str, float]:
    """Draw a queue: the number of cars, at most as many as fit on the lane, and their speed."""
    cars = draw.randint(CARS[0], max(min(CARS[1], int(place.lane_ahead / CAR_SPACING)), CARS[0]))
    return {"cars": float(cars), "speed": draw.uniform(*CRAWL) if draw.random() < CRAWLING else 0.0}


def crossing(place: Place, draw: random.Random) -> dict[str, float] | None:
    """Draw a crossing pedestrian or cyclist; some come from the right behind a parked van."""
    return _crossing(place, draw, hidden=HIDDEN)


def open_crossing(place: Place, draw: random.Random) -> dict[str, float] | None:
    """Draw a crossing as `crossing`, but never behind a van."""
    return _crossing(place, draw, hidden=0.0)


def _crossing(place: Place, draw: random.Random, *, hidden: float) -> dict[str, float] | None:
    """Draw a crossing; return None if any crossing here would be unavoidable."""
    side = 1 if 1 in place.sides and draw.random() < FROM_LEFT else -1
    rider = draw.random() < RIDERS
    behind = hidden > 0.0 and side < 0 and draw.random() < hidden
    for is_rider in (rider, not rider):
        low, high = crossing_speeds(place.limit, rider=is_rider, side=side)
        if low <= high:
            speed = draw.uniform(low, high)
            return {"speed": speed, "side": side, "rider": float(is_rider), "hidden": float(behind)}
    return None


def crossing_speeds(limit: float, *, rider: bool, side: int) -> tuple[float, float]:
    """Return the lowest and the highest speed of an avoidable crossing, m/s.

    A crossing from the left starts beyond the oncoming lane, which sets a minimum speed.
    """
    length = RIDER_LENGTH if rider else WALKER_LENGTH
    meets = meets_at(length)
    unit = needed_start(1.0, limit, length) - meets
    low, high = RIDING if rider else WALKING
    if side > 0:
        low = max(low, (KERB_LEFT - meets) / (unit * (1.0 - SPEED_SPREAD)))
        high = max(high, RUNNING)
    return low, min(high, (FARTHEST_START - meets) / (unit * (1.0 + SPEED_SPREAD)))
