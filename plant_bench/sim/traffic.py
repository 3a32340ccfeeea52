"""Background traffic in the surroundings of the ego.

Vehicles are kept at a density around the ego only, so that the cost of a tick does not depend on
the size of the town. They enter and leave out of the ego's sight; jams are also dissolved out of
sight.
"""

import math
import random
from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from plant_bench.sim.entry_lanes import SAMPLE_SPACING, StreetGrid
from plant_bench.sim.sumo import Sumo
from plant_bench.sim.vehicle_types import VEHICLE_TYPES, VehicleType
from plant_bench.world.actor_ids import TRAFFIC
from plant_bench.world.scene import EGO_LENGTH, ActorKind

SIGHT = 80.0  # m: visible range of the ego; nothing appears or disappears within
ENTRY_RADIUS = 110.0  # m: nearest entry; a car at 20 m/s becomes visible after more than 1 s
FILL_RADIUS = 135.0  # m: the density is kept within this distance of the ego
EXIT_RADIUS = 165.0  # m: beyond it vehicles are removed
JAM_TIME = 45.0  # s that a vehicle out of sight is stationary before it is removed
MANAGE_INTERVAL = 10  # ticks between two updates of the population: 0.5 s
ENTRIES = 6  # vehicles that may enter at one update
COMFORTABLE_BRAKING = 2.5  # m/s2: limit for an entering vehicle before its lane's end
STANDING_GAP = 4.5  # m kept free around an entering vehicle, and its headway in s
ENTRY_HEADWAY = 1.2
MIX_GAIN = 3.0  # how strongly a kind below its share is preferred

_Taken = tuple[float, float, float]  # x, y and length of a vehicle


class Traffic:
    """The vehicles around the ego; mutable.

    Args:
        sumo: The running simulation.
        streets: Entry points and routes.
        density: Vehicles per lane-km.
        seed: Seed of all random draws.

    Attributes:
        types: Vehicle types by actor id.
        scripted: Vehicles under a hazard's command, which are left alone.
    """

    def __init__(self, sumo: Sumo, streets: StreetGrid, density: float, seed: int) -> None:
        self._sumo = sumo
        self._streets = streets
        self._density = density
        self._draw = random.Random(seed)
        self._next = TRAFFIC.start
        self._looks = 0
        mix = streets.town.life.mix
        self._mix = {ActorKind[name.upper()]: share for name, share in mix.items() if share > 0.0}
        self._types = {
            kind: [row for row in VEHICLE_TYPES if row.kind is kind] for kind in self._mix
        }
        self._shares = {kind: [row.share for row in rows] for kind, rows in self._types.items()}
        self.types: dict[int, VehicleType] = {}
        self.scripted: set[int] = set()

    def number(self) -> int:
        """Return the actor id of a new vehicle."""
        self._next += 1
        return self._next - 1

    def fill(self, x: float, y: float) -> None:
        """Add vehicles on all streets around the ego, before the episode starts."""
        self._enter(x, y, inner=15.0, most=10_000)

    def manage(self, x: float, y: float) -> None:
        """Remove distant or jammed vehicles and add others; call every `MANAGE_INTERVAL`."""
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

    def onward(self, edge: str, kind: ActorKind, draw: random.Random) -> list[str]:
        """Return random edges that continue from an edge for a kind of vehicle."""
        return self._streets.walk(edge, kind, draw)

    def _lengthen(self, vehicle: int) -> None:
        edges = self._sumo.remaining_route(vehicle)
        if len(edges) < 5:
            kind = self.types[vehicle].kind
            onward = self.onward(list(edges)[-1], kind, self._draw)
            self._sumo.set_route(vehicle, (*edges, *onward))

    def _enter(self, x: float, y: float, *, inner: float, most: int) -> None:
        streets = self._streets
        square = (streets.x - x) ** 2 + (streets.y - y) ** 2
        within = square < FILL_RADIUS**2
        target = round(self._density * np.count_nonzero(within) * SAMPLE_SPACING / 1000.0)
        present = self._sumo.vehicles()
        kinds = [self.types[vehicle].kind for vehicle in present]
        missing = min(target - len(kinds) + kinds.count(ActorKind.PEDESTRIAN), most)
        if missing <= 0:
            return
        places = self._places(within & (square > inner**2))
        if not places:
            return
        taken = [(x, y, EGO_LENGTH), *map(self._occupied, present)]
        counts = {kind: kinds.count(kind) for kind in places}
        for _ in range(4 * missing):
            kind = self._draw_kind(counts)
            place = int(places[kind][self._draw.randrange(places[kind].size)])
            row = self._draw.choices(self._types[kind], self._shares[kind])[0]
            if self._enter_at(place, row, taken):
                taken.append((float(streets.x[place]), float(streets.y[place]), row.length))
                counts[kind] += 1
                missing -= 1
                if missing == 0:
                    return

    def _occupied(self, vehicle: int) -> _Taken:
        x, y = self._sumo.position(vehicle)
        return x, y, self.types[vehicle].length

    def _places(self, allowed: np.ndarray) -> dict[ActorKind, Int[np.ndarray, " places"]]:
        """Return the entry points available to each kind; kinds without any are left out."""
        found = {kind: np.flatnonzero(allowed & self._streets.open_to(kind)) for kind in self._mix}
        return {kind: places for kind, places in found.items() if places.size}

    def _draw_kind(self, counts: dict[ActorKind, int]) -> ActorKind:
        """Draw the kind to enter next by its share, preferring kinds below their share.

        Kinds leave at different rates, so that drawing by share alone would not keep the mix.
        """
        total = (sum(counts.values()) + 1) / sum(self._mix[kind] for kind in counts)
        weights = []
        for kind, count in counts.items():
            target = self._mix[kind] * total
            weights.append(target * max(1.0 + MIX_GAIN * (target - count) / max(target, 1.0), 0.0))
        return self._draw.choices(list(counts), weights)[0]

    def _enter_at(self, place: int, row: VehicleType, taken: Sequence[_Taken]) -> bool:
        """Add a vehicle at an entry point; False if the point is occupied.

        Plain Python is faster here: most occupied points are detected by the first vehicles.
        """
        streets = self._streets
        lane = streets.lanes[streets.lane_of[place]]
        length = self._sumo.lane_length(lane.id)
        at = streets.share[place] * length
        brakable_speed = math.sqrt(2.0 * COMFORTABLE_BRAKING * max(length - at - 8.0, 0.0))
        speed = min(0.8 * lane.speed_limit, brakable_speed, row.top_speed)
        px, py, headway = float(streets.x[place]), float(streets.y[place]), ENTRY_HEADWAY * speed
        for x, y, other in taken:
            gap = STANDING_GAP + max(other, row.length) + headway
            dx, dy = x - px, y - py
            if dx * dx + dy * dy < gap * gap:
                return False
        number = self.number()
        self.types[number] = row
        edges = streets.walk_from(lane, row.kind, self._draw)
        self._sumo.add_vehicle(number, row.name, edges, lane.index, at, speed)
        return True
