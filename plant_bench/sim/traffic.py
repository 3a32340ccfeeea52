"""Background traffic in a moving neighbourhood of the ego.

Vehicles are kept at a density around the ego and nowhere else, so that a tick costs what is near
the ego and not what the town is large. They enter and leave out of the ego's sight; a jam is
dissolved out of its sight too, so that the ego and what it sees are never touched.
"""

import math
import random
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plant_bench.errors import InputError
from plant_bench.sim.sumo import Sumo
from plant_bench.world.scene import ActorKind
from plant_bench.world.town import Lane, Town

DENSITIES = {"empty": 0.0, "light": 4.0, "medium": 8.0, "dense": 20.0}  # vehicles per lane-km
SIGHT = 80.0  # m: what the ego may see, and nothing appears or vanishes in
ENTRY_RADIUS = 110.0  # m: nearest place to enter; a car at 20 m/s is seen after more than a second
FILL_RADIUS = 160.0  # m: the density is kept within this distance of the ego
EXIT_RADIUS = 190.0  # m: beyond it vehicles are taken away
JAM_TIME = 45.0  # s of standing out of sight until a vehicle is taken away
MANAGE_INTERVAL = 10  # ticks between two looks at the population: 0.5 s
ENTRIES = 6  # vehicles that may enter at one look
SAMPLE_SPACING = 10.0  # m between the places at which vehicles may enter
ROUTE_AHEAD = 500.0  # m of random walk that a vehicle is given at a time
STRAIGHT_WEIGHT = 3.0  # how much likelier a vehicle goes straight on than into one of the turns
COMFORTABLE_BRAKING = 2.5  # m/s2 that an entering vehicle must not exceed before its lane's end


@dataclass(frozen=True)
class VehicleType:
    """A row of vehicle_types.add.xml: its id, size in metres, kind and share of the traffic."""

    name: str
    length: float
    width: float
    kind: ActorKind
    share: float


VEHICLE_TYPES = (
    VehicleType("car_small", 3.97, 1.75, ActorKind.CAR, 0.30),
    VehicleType("car_medium", 4.47, 1.84, ActorKind.CAR, 0.40),
    VehicleType("car_large", 4.86, 1.92, ActorKind.CAR, 0.20),
    VehicleType("van", 5.32, 2.01, ActorKind.VAN, 0.10),
)


def density_of(name: str) -> float:
    """Return a density in vehicles per lane-km.

    Raises:
        InputError: There is no density of this name.
    """
    if name not in DENSITIES:
        message = f"There is no density '{name}'. Densities: {', '.join(DENSITIES)}."
        raise InputError(message)
    return DENSITIES[name]


class StreetGrid:
    """Where in a town vehicles may enter, and where they may go from there; immutable.

    Args:
        town: The town.
    """

    def __init__(self, town: Town) -> None:
        self._town = town
        self.lanes: list[Lane] = []
        self.lane_of: list[int] = []
        shares: list[float] = []
        xs: list[float] = []
        ys: list[float] = []
        for lane in town.lanes.values():
            if lane.junction is not None or lane.acceleration or lane.length < 2 * SAMPLE_SPACING:
                continue
            if lane.id not in town.links_from:
                continue
            self.lanes.append(lane)
            at = np.arange(SAMPLE_SPACING, lane.length - SAMPLE_SPACING, SAMPLE_SPACING)
            xs += np.interp(at, lane.along, lane.points[:, 0]).tolist()
            ys += np.interp(at, lane.along, lane.points[:, 1]).tolist()
            shares += (at / lane.length).tolist()
            self.lane_of += [len(self.lanes) - 1] * len(at)
        self.x, self.y = np.array(xs), np.array(ys)
        self.share = shares

    @cached_property
    def _onward(self) -> dict[str, tuple[list[str], list[float]]]:
        found: dict[str, dict[str, float]] = {}
        lanes = self._town.lanes
        for link in self._town.links:
            weight = STRAIGHT_WEIGHT if link.turn == "straight" else 1.0
            onward = found.setdefault(lanes[link.source].edge, {})
            target = lanes[link.target].edge
            onward[target] = max(onward.get(target, 0.0), weight)
        return {edge: (list(onward), list(onward.values())) for edge, onward in found.items()}

    def walk(self, edge: str, draw: random.Random, length: float) -> list[str]:
        """Return a random walk of at least `length` metres that begins after an edge."""
        edges: list[str] = []
        while length > 0.0:
            onward, weights = self._onward[edge]
            edge = draw.choices(onward, weights)[0]
            edges.append(edge)
            length -= self._town.edges[edge][0].length
        return edges

    def walk_from(self, lane: Lane, draw: random.Random) -> tuple[str, ...]:
        """Return a random walk that begins on a lane and leaves it without a lane change."""
        links = self._town.links_from[lane.id]
        first = self._town.lanes[draw.choice(links).target].edge
        return (lane.edge, first, *self.walk(first, draw, ROUTE_AHEAD))


class Traffic:
    """The vehicles around the ego; mutable.

    Args:
        sumo: The running simulation.
        streets: Where vehicles may be.
        density: Vehicles per lane-km.
        seed: Seeds all that is drawn here.

    Attributes:
        types: What each vehicle is, by number.
        scripted: Vehicles that a hazard commands; they are left alone here.
    """

    def __init__(self, sumo: Sumo, streets: StreetGrid, density: float, seed: int) -> None:
        self._sumo = sumo
        self._streets = streets
        self._density = density
        self._draw = random.Random(seed)
        self._number = 0
        self._looks = 0
        self._shares = [kind.share for kind in VEHICLE_TYPES]
        self.types: dict[int, VehicleType] = {}
        self.scripted: set[int] = set()

    def number(self) -> int:
        """Return the number of a new vehicle."""
        self._number += 1
        return self._number

    def fill(self, x: float, y: float) -> None:
        """Put vehicles on all streets around the ego, before the episode starts."""
        self._enter(x, y, inner=15.0, most=10_000)

    def manage(self, x: float, y: float) -> None:
        """Take away what is far or jammed, and let others enter; call every `MANAGE_INTERVAL`."""
        self._looks += 1
        for vehicle in self._sumo.vehicles():
            if vehicle in self.scripted:
                continue
            vx, vy = self._sumo.position(vehicle)
            distance = math.hypot(vx - x, vy - y)
            if distance > EXIT_RADIUS:
                self._sumo.remove(vehicle)
            elif (vehicle + self._looks) % 8 == 0:
                jammed = distance > ENTRY_RADIUS and self._sumo.waiting_time(vehicle) > JAM_TIME
                if jammed:
                    self._sumo.remove(vehicle)
                else:
                    self._lengthen(vehicle)
        self._enter(x, y, inner=ENTRY_RADIUS, most=ENTRIES)

    def _lengthen(self, vehicle: int) -> None:
        edges = self._sumo.remaining_route(vehicle)
        if len(edges) < 5:
            onward = self._streets.walk(list(edges)[-1], self._draw, ROUTE_AHEAD)
            self._sumo.set_route(vehicle, (*edges, *onward))

    def _enter(self, x: float, y: float, *, inner: float, most: int) -> None:
        streets = self._streets
        square = (streets.x - x) ** 2 + (streets.y - y) ** 2
        within = square < FILL_RADIUS**2
        wanted = round(self._density * np.count_nonzero(within) * SAMPLE_SPACING / 1000.0)
        present = [self._sumo.position(vehicle) for vehicle in self._sumo.vehicles()]
        places = np.flatnonzero(within & (square > inner**2))
        missing = min(wanted - len(present), most)
        if missing <= 0 or places.size == 0:
            return
        taken = np.array([(x, y), *present])
        for _ in range(4 * missing):
            place = int(places[self._draw.randrange(places.size)])
            speed = self._enter_at(place, taken)
            if speed is not None:
                taken = np.vstack((taken, (streets.x[place], streets.y[place])))
                missing -= 1
                if missing == 0:
                    return

    def _enter_at(self, place: int, taken: np.ndarray) -> float | None:
        streets = self._streets
        lane = streets.lanes[streets.lane_of[place]]
        length = self._sumo.lane_length(lane.id)
        at = streets.share[place] * length
        room = math.sqrt(2.0 * COMFORTABLE_BRAKING * max(length - at - 8.0, 0.0))
        speed = min(0.8 * lane.speed_limit, room)
        gap = 9.0 + 1.2 * speed
        nearest = np.min(
            (taken[:, 0] - streets.x[place]) ** 2 + (taken[:, 1] - streets.y[place]) ** 2
        )
        if nearest < gap**2:
            return None
        number = self.number()
        kind = self._draw.choices(VEHICLE_TYPES, self._shares)[0]
        self.types[number] = kind
        edges = streets.walk_from(lane, self._draw)
        self._sumo.add_vehicle(number, kind.name, edges, lane.index, at, speed)
        return speed
