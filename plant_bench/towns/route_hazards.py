"""Chooses the hazards of a route: number, kinds, places and parameters.

Kinds and places are drawn with a seed. The shares follow the scenarios of the routes of Longest6 v2
(DynamicObjectCrossing 116, SignalizedJunctionLeftTurn 112, ControlLoss 80,
SignalizedJunctionRightTurn 76, OppositeVehicleRunningRedLight 43, 11.9 per route); a third of the
hazards are of kinds that CARLA does not have.
"""

import random
from collections import Counter

from plant_bench.towns.hazard_places import Place, possible_places
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.hazard_table import HAZARDS, load_part
from plant_bench.world.route import Route
from plant_bench.world.town import Town

FEWEST, MOST = 8, 15  # hazards of a route
METRES_EACH = 120.0  # m of route per hazard, within those bounds
SPACING = 60.0  # m: minimum distance between two hazards
LARGEST_SHARE = 1.0 / 3.0  # largest share of a route's hazards of the same kind
TRIES = 400  # attempts to place all hazards of a route
CONTENDERS = 3  # random places per hazard; the one farthest from the other hazards is used


def place_hazards(town: Town, route: Route, seed: int) -> tuple[Hazard, ...]:
    """Return the hazards of a route, sorted by place; equal arguments give equal hazards."""
    draw = random.Random(f"{seed}|{route.id}")
    places = possible_places(town, route)
    target = min(max(round(route.length / METRES_EACH), FEWEST), MOST)
    best: list[Place] = []
    for _ in range(TRIES):
        chosen = _choose(places, target, draw)
        if len(chosen) > len(best):
            best = chosen
        if len(best) == target:
            break
    best.sort(key=lambda place: place.at)
    hazards = (_make(place, draw) for place in best)
    return tuple(hazard for hazard in hazards if hazard is not None)


def _choose(places: list[Place], target: int, draw: random.Random) -> list[Place]:
    free: dict[HazardKind, list[Place]] = {}
    for place in places:
        free.setdefault(place.kind, []).append(place)
    chosen: list[Place] = []
    counts = Counter[HazardKind]()
    while free and len(chosen) < target:
        kinds = list(free)
        kind = draw.choices(kinds, [HAZARDS[kind].weight for kind in kinds])[0]
        some = draw.sample(free[kind], min(CONTENDERS, len(free[kind])))
        place = max(some, key=lambda one: min((abs(one.at - p.at) for p in chosen), default=0.0))
        chosen.append(place)
        counts[kind] += 1
        if counts[kind] + 1 > LARGEST_SHARE * target:
            del free[kind]
        free = {
            kind: left
            for kind, all_left in free.items()
            if (left := [one for one in all_left if abs(one.at - place.at) >= SPACING + 2.0])
        }
    return chosen


def _make(place: Place, draw: random.Random) -> Hazard | None:
    """Return the hazard of a place, or None if it would be unavoidable."""
    at, row = place.at, HAZARDS[place.kind]
    seed = draw.randrange(2**31)
    parameters = dict(place.parameters)
    for name, (low, high) in row.ranges.items():
        parameters[name] = draw.uniform(low, high)
    if row.numbers:
        numbers = load_part(place.kind, "numbers")(place, draw)
        if numbers is None:
            return None
        parameters |= numbers
    if row.spread:
        at += draw.uniform(-row.spread, row.spread)
    rounded = {name: round(float(value), 4) for name, value in parameters.items()}
    return Hazard(place.kind, round(float(at), 2), round(place.arm, 2), seed, rounded)
