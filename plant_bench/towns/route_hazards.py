"""The hazards of a route: how many, which, where, and with what numbers.

Kinds and places are drawn by a seed. Shares follow the scenarios of Longest6 v2's routes
(DynamicObjectCrossing 116, SignalizedJunctionLeftTurn 112, ControlLoss 80,
SignalizedJunctionRightTurn 76, OppositeVehicleRunningRedLight 43, 11.9 a route); a third is left to
the kinds beyond CARLA's.
"""

import random
from collections import Counter

from plant_bench.towns.hazard_places import Place, possible_places
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.route import Route
from plant_bench.world.scene import WHEELBASE
from plant_bench.world.town import Town

FEWEST, MOST = 8, 15  # hazards of a route
METRES_EACH = 120.0  # m of route for each hazard between those bounds
SPACING = 60.0  # m between two hazards at least
LARGEST_SHARE = 1.0 / 3.0  # of a route's hazards that are of one kind
TRIES = 400  # draws of a route's places until all wanted fit
CONTENDERS = 3  # places drawn, of which the one farthest from others is taken

# How likely a kind is drawn while it has a place left; rare places weigh more.
WEIGHTS = {
    HazardKind.CROSSING: 13.0,
    HazardKind.CONTROL_LOSS: 9.0,
    HazardKind.UNPROTECTED_LEFT: 26.0,
    HazardKind.RIGHT_TURN: 16.0,
    HazardKind.RED_LIGHT_RUNNER: 8.0,
    HazardKind.UNSIGNALLED_CROSSING: 14.0,
    HazardKind.CROSSING_AFTER_TURN: 5.0,
    HazardKind.HARD_BRAKE: 5.0,
    HazardKind.CUT_IN: 12.0,
    HazardKind.QUEUE_TAIL: 4.0,
    HazardKind.BLOCKED_LANE: 9.0,
    HazardKind.MERGE_PRESSURE: 9.0,
}

# Numbers of the kinds that need no more than a draw; SI units, named as in `sim.hazards`.
RANGES = {
    HazardKind.HARD_BRAKE: {"braking": (6.0, 8.0), "wait": (2.0, 4.0)},
    HazardKind.CUT_IN: {"gap": (6.0, 8.0), "duration": (2.2, 2.5), "braking": (2.5, 3.5)},
    HazardKind.BLOCKED_LANE: {"wait": (15.0, 30.0)},
    HazardKind.QUEUE_TAIL: {"wait": (12.0, 18.0), "pause": (1.5, 3.0)},
}
CARS, CAR_ROOM = (3, 6), 7.6  # of a queue; m that each takes
CRAWLING, CRAWL = 0.4, (1.0, 2.0)  # share of queues that crawl; m/s

# A walker or rider, as `sim.hazards.crossing` moves it: how far beside the path it must start for a
# surprised driver at the speed limit to stop, and how far it can start.
FARTHEST_START = 9.0  # m
KERB_LEFT = 5.3  # m beside the path: behind the oncoming lane
HALF_WIDTHS = {False: 1.315, True: 1.965}  # m from walker and rider to the path when they meet
SPEED_SPREAD = 0.1  # share by which repetitions differ in speed
TIME_SPARE = 1.15
WALKING, RIDING = (1.0, 2.0), (2.0, 4.0)  # m/s
RUNNING = 2.8  # m/s of who runs across from the left
RIDERS, HIDDEN, FROM_LEFT = 0.3, 0.4, 0.3  # shares of crossings

# Control loss: the metres aside that hands off the wheel would leave; the pull follows from them.
ASIDE = (1.6, 2.8)  # m
SLIP_TIME = (1.5, 2.5)  # s
HARDEST_PULL = 0.12  # rad


def place_hazards(town: Town, route: Route, seed: int) -> tuple[Hazard, ...]:
    """Return a route's hazards in order of place; equal arguments give equal hazards."""
    draw = random.Random(f"{seed}|{route.id}")
    places = possible_places(town, route)
    wanted = min(max(round(route.length / METRES_EACH), FEWEST), MOST)
    best: list[Place] = []
    for _ in range(TRIES):
        chosen = _choose(places, wanted, draw)
        if len(chosen) > len(best):
            best = chosen
        if len(best) == wanted:
            break
    best.sort(key=lambda place: place.at)
    hazards = (_make(place, draw) for place in best)
    return tuple(hazard for hazard in hazards if hazard is not None)


def _choose(places: list[Place], wanted: int, draw: random.Random) -> list[Place]:
    free: dict[HazardKind, list[Place]] = {}
    for place in places:
        free.setdefault(place.kind, []).append(place)
    chosen: list[Place] = []
    counts = Counter[HazardKind]()
    while free and len(chosen) < wanted:
        kinds = list(free)
        kind = draw.choices(kinds, [WEIGHTS[kind] for kind in kinds])[0]
        some = draw.sample(free[kind], min(CONTENDERS, len(free[kind])))
        place = max(some, key=lambda one: min((abs(one.at - p.at) for p in chosen), default=0.0))
        chosen.append(place)
        counts[kind] += 1
        if counts[kind] + 1 > LARGEST_SHARE * wanted:
            del free[kind]
        free = {
            kind: left
            for kind, all_left in free.items()
            if (left := [one for one in all_left if abs(one.at - place.at) >= SPACING + 2.0])
        }
    return chosen


def _make(place: Place, draw: random.Random) -> Hazard | None:
    """Return the hazard of a place, or None where nobody could survive it."""
    at = place.at
    seed = draw.randrange(2**31)
    parameters = dict(place.parameters)
    for name, (low, high) in RANGES.get(place.kind, {}).items():
        parameters[name] = draw.uniform(low, high)
    if place.kind is HazardKind.CONTROL_LOSS:
        parameters |= _slip(place.limit, draw)
    if place.kind is HazardKind.QUEUE_TAIL:
        parameters |= _queue(place, draw)
    if place.kind in (HazardKind.CROSSING, HazardKind.CROSSING_AFTER_TURN):
        crossing = _crossing(place, draw)
        if crossing is None:
            return None
        parameters |= crossing
    if place.kind is HazardKind.CROSSING_AFTER_TURN:
        at += draw.uniform(-2.0, 2.0)
    numbers = {name: round(float(value), 4) for name, value in parameters.items()}
    return Hazard(place.kind, round(float(at), 2), round(place.arm, 2), seed, numbers)


def _slip(limit: float, draw: random.Random) -> dict[str, float]:
    """How long and hard the wheels are pulled: a sine that would leave the ego so far aside."""
    duration = draw.uniform(*SLIP_TIME)
    travelled = limit * duration
    pull = 6.2832 * WHEELBASE * draw.uniform(*ASIDE) / travelled**2
    return {"duration": duration, "pull": min(pull, HARDEST_PULL)}


def _queue(place: Place, draw: random.Random) -> dict[str, float]:
    """How many cars, no more than fit on the lane, and how fast they crawl."""
    cars = draw.randint(CARS[0], max(min(CARS[1], int(place.room / CAR_ROOM)), CARS[0]))
    return {"cars": float(cars), "speed": draw.uniform(*CRAWL) if draw.random() < CRAWLING else 0.0}


def needed_start(speed: float, limit: float, *, rider: bool) -> float:
    """Return how far beside the path a crossing must start to be survivable, metres.

    The time from first sight to the meeting must be enough for reaction (0.5 s), a stop with
    4 m/s2 from the speed limit, and a metre and a half to spare.
    """
    return HALF_WIDTHS[rider] + speed * TIME_SPARE * (0.5 + limit / 8.0 + 1.5 / limit)


def crossing_speeds(limit: float, *, rider: bool, side: int) -> tuple[float, float]:
    """Return the least and the greatest speed of a survivable crossing, m/s.

    From the left one starts behind the oncoming lane, hence not too slowly.
    """
    unit = needed_start(1.0, limit, rider=rider) - HALF_WIDTHS[rider]
    low, high = RIDING if rider else WALKING
    if side > 0:
        low = max(low, (KERB_LEFT - HALF_WIDTHS[rider]) / (unit * (1.0 - SPEED_SPREAD)))
        high = max(high, RUNNING)
    return low, min(high, (FARTHEST_START - HALF_WIDTHS[rider]) / (unit * (1.0 + SPEED_SPREAD)))


def _crossing(place: Place, draw: random.Random) -> dict[str, float] | None:
    """Who crosses, from where and how fast; None where all would be too fast to be avoided."""
    side = 1 if 1 in place.sides and draw.random() < FROM_LEFT else -1
    rider = draw.random() < RIDERS
    hidden = place.kind is HazardKind.CROSSING and side < 0 and draw.random() < HIDDEN
    for who in (rider, not rider):
        low, high = crossing_speeds(place.limit, rider=who, side=side)
        if low <= high:
            speed = draw.uniform(low, high)
            return {"speed": speed, "side": side, "rider": float(who), "hidden": float(hidden)}
    return None
