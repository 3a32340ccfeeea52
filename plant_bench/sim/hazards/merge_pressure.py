"""Merge pressure: a row of vehicles is beside the ego where its route changes lanes.

One vehicle is beside the ego in the middle of the lane change; others follow it in a row. They do
not yield while the ego is beside their lane, and yield when the ego's box is in it.
"""

import math
import random

import numpy as np

from plant_bench.geometry.box import corners
from plant_bench.geometry.polyline import arc_lengths, distances_to
from plant_bench.sim.hazards.arrival import expected_arrival, speed_to_arrive, time_to_go
from plant_bench.sim.hazards.behaviour import HoldsTraffic
from plant_bench.sim.hazards.conflicting_vehicle import ConflictingVehicle, place_on, spawn_on
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.conflicting_paths import Approach, clear_place, joined_line, lane_starts
from plant_bench.world.driver_braking import SPARE
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EgoState
from plant_bench.world.town import Lane, Link, Town

FREEZE_MARGIN = 3.0  # m of slack beyond `SPARE` at which the vehicle's speed is frozen
ARRIVAL_TOLERANCE = 0.5  # s between both arrivals up to which they are beside each other
SLOWEST, FASTEST = 0.4, 1.4  # times the limit, of a vehicle that gets into place
MERGED = -25.0  # m to the lane change at which the ego has merged
RUN = 260.0  # m of lane, junctions included, for a vehicle to get into place
MAX_DURATION = 20.0  # s
LOOK = 4  # ticks between two queries of the lane's vehicles
ROW = 90.0  # m behind the vehicle beside the ego; vehicles there belong to its row
INSIDE = 1.3  # m from a lane's centre line within which a box blocks the lane
GAP = 2.0  # m kept behind the ego
YIELDING, HARDEST = 4.0, 8.0  # m/s2 with which vehicles yield normally, and at most


class MergePressure(HoldsTraffic):
    """A row of vehicles in the lane that the ego changes to; mutable.

    Parameters: `vehicles` (number spawned), `gap` (s from front to front).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._void_reason = "no vehicle could be there in time"
        self._draw = draw
        count = int(hazard.parameters.get("vehicles", draw.randint(1, 3)))
        gap = hazard.parameters.get("gap", 2.0)
        self._gaps = [gap * draw.uniform(1.0, 1.3) for _ in range(count - 1)]
        self._at = hazard.at
        self._limit = world.speed_limit_at(hazard.at)
        self._pace = self._limit
        self._begun = math.inf
        self._way = lane_at(world, hazard.at)
        self.conflicting: ConflictingVehicle | None = None
        self.vehicles: list[int] = []
        if self._way is None:
            self.phase, self.reason = Phase.VOID, "the route has no lane change here"

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Bring a vehicle beside the ego, and release the row when the ego has merged."""
        way = self._way
        if way is None:
            return
        if self.conflicting is None:
            self._seek(ego, world, way)
            return
        front = self.conflicting.front(world)
        if self.phase is Phase.ARMED:
            self._adapt(ego, world, self.conflicting, front)
        elif world.distance_to(self._at) < MERGED or self._is_stale(ego, world, way):
            self.end(world, Phase.DONE)
        if self.conflicting is not None:
            self._drive(ego, world, self.conflicting, front)

    def _is_stale(self, ego: EgoState, world: HazardWorld, way: Approach) -> bool:
        """Tell whether the hazard took too long; a row that yields continues to do so."""
        lasted = world.time - self._begun
        return lasted > MAX_DURATION and (
            lasted > 3.0 * MAX_DURATION or place_inside(ego, way) is None
        )

    def _seek(self, ego: EgoState, world: HazardWorld, way: Approach) -> None:
        if not world.avoidable(ego, way.clear):
            self.end(world, Phase.VOID, self._void_reason)
            return
        if world.tick % LOOK:
            return
        time = expected_arrival(ego, world, self._at)
        vehicle = self._best_present(world, way, time)
        if vehicle is None:
            pace = self._draw.uniform(0.6, 1.2) * self._limit
            vehicle = spawn_on(world, way, pace * time, pace, self._draw)
        if vehicle is not None:
            self.conflicting = ConflictingVehicle(world, way, vehicle)

    def _best_present(self, world: HazardWorld, way: Approach, time: float) -> int | None:
        """Return the vehicle that needs the least change of speed to be beside the ego."""
        best, least = None, math.inf
        for lane, start in way.starts.items():
            for vehicle, position, speed in world.lane_state(lane):
                to_go = way.meets + 0.5 * world.kind_of(vehicle).length - start - position
                pace = speed_to_arrive(to_go, time, speed)
                fits = SLOWEST * self._limit < pace < FASTEST * self._limit
                if fits and abs(pace - speed) < least and not world.is_commanded(vehicle):
                    best, least = vehicle, abs(pace - speed)
        return best

    def _adapt(
        self,
        ego: EgoState,
        world: HazardWorld,
        conflicting: ConflictingVehicle,
        front: float | None,
    ) -> None:
        if front is None:
            gone = not world.on_road(conflicting.vehicle)
            self._void_reason = (
                "SUMO did not insert the vehicle" if gone else "the vehicle left the lane"
            )
            self.let_go(world)
            return
        time = expected_arrival(ego, world, self._at)
        speed, to_go = conflicting.speed(world), conflicting.way_to_go(front)
        self._pace = min(speed_to_arrive(to_go, time, speed), FASTEST * self._limit)
        clear = conflicting.approach.clear
        meets = abs(time_to_go(to_go, speed, self._pace) - time) <= ARRIVAL_TOLERANCE
        if not world.avoidable(ego, clear):
            reason = (
                "the ego was too near to stop"
                if meets
                else "the vehicle could not be there in time"
            )
            self.end(world, Phase.VOID, reason)
        elif meets and world.slack(ego, clear) <= SPARE + FREEZE_MARGIN:
            self.phase, self._begun = Phase.COMMITTED, world.time
        elif not meets:
            self._void_reason = "the vehicle could not be there in time"
            if (
                world.tick % LOOK == 0
                and self._best_present(world, conflicting.approach, time) is not None
            ):
                self.let_go(world)

    def _drive(
        self,
        ego: EgoState,
        world: HazardWorld,
        conflicting: ConflictingVehicle,
        front: float | None,
    ) -> None:
        """Drive the row; its first vehicle obeys rules until it has passed all junctions."""
        way, inside = conflicting.approach, None
        if self.phase is Phase.COMMITTED:
            inside = place_inside(ego, way)
        if front is not None:
            free = front > way.starts[way.link.target]
            self._go(world, conflicting.vehicle, front, inside, ignores_rules=free)
            if free:
                conflicting.publish_path(world, front)
        places = {one: place_on(world, way, one) for one in self.vehicles}
        for vehicle, place in places.items():
            if place is not None:
                self._go(world, vehicle, place, inside, ignores_rules=False)
        if front is not None and world.tick % LOOK == 0:
            self._follow(world, way, [front, *(x for x in places.values() if x is not None)])

    def _go(
        self,
        world: HazardWorld,
        vehicle: int,
        front: float,
        inside: float | None,
        *,
        ignores_rules: bool,
    ) -> None:
        """Drive a vehicle at the row's pace, or yield to an ego inside its lane."""
        if inside is None or front > inside + EGO_LENGTH:
            world.drive(vehicle, self._pace, ignores_rules=ignores_rules)
            return
        state = world.state_of(vehicle)
        speed = 0.0 if state is None else state.speed
        distance = max(inside - GAP - front, 0.1)
        if speed**2 / (2.0 * distance) > YIELDING:
            world.drive(vehicle, 0.0)
            world.brake_hard(vehicle, HARDEST)
        else:
            world.drive(vehicle, min(self._pace, math.sqrt(2.0 * YIELDING * distance)))

    def _follow(self, world: HazardWorld, way: Approach, known: list[float]) -> None:
        """Take vehicles behind into the row, and spawn its next one."""
        first = known[0]
        for lane, start in way.starts.items():
            for vehicle, position, _ in world.lane_state(lane):
                if -ROW < start + position - first < 0.0 and not world.is_commanded(vehicle):
                    self._join(world, vehicle)
        if self._gaps:
            to_go = way.meets - min(known) + self._gaps[0] * self._limit
            vehicle = spawn_on(world, way, to_go, self._limit, self._draw)
            if vehicle is not None:
                self._gaps.pop(0)
                self._join(world, vehicle)

    def _join(self, world: HazardWorld, vehicle: int) -> None:
        world.command(vehicle)
        self.vehicles.append(vehicle)

    def let_go(self, world: HazardWorld) -> None:
        """Return the whole row to the traffic."""
        for vehicle in self.vehicles:
            world.release(vehicle)
        self.vehicles.clear()
        if self.conflicting is not None:
            self.conflicting.let_go(world)
            self.conflicting = None


def place_inside(ego: EgoState, way: Approach) -> float | None:
    """Return the arc length of the ego's rear on a lane that its box blocks; else None."""
    box = corners(np.array([ego.pose]), np.array([EGO_EXTENT]))[0]
    if distances_to(way.line, box).min() > INSIDE:
        return None
    where = np.arange(0.0, float(way.along[-1]), 1.0)
    x, y = (np.interp(where, way.along, way.line[:, axis]) for axis in (0, 1))
    return float(where[np.argmin(np.hypot(x - ego.x, y - ego.y))]) - 0.5 * EGO_LENGTH


def lane_at(world: HazardWorld, at: float) -> Approach | None:
    """Return the lane that the route changes to at an arc length, as a conflicting approach."""
    route, town = world.route, world.town
    change = next((c for c in route.lane_changes if c.start - 5.0 <= at <= c.end + 5.0), None)
    span = next((span for span in route.lanes if span.start >= at), None)
    if change is None or span is None or span.lane not in town.lanes:
        return None
    lanes = [town.lanes[span.lane]]
    while sum(lane.length for lane in lanes) < RUN and (before := _lanes_before(town, lanes[0])):
        lanes = before + lanes
    line, starts = joined_line(lanes), lane_starts(lanes)
    end = starts[span.lane] + lanes[-1].length
    x, y, _ = world.pose_at(at)
    where = np.arange(0.0, end, 1.0)
    on_line = [np.interp(where, arc_lengths(line), line[:, axis]) for axis in (0, 1)]
    meets = float(where[np.argmin(np.hypot(on_line[0] - x, on_line[1] - y))])
    stretch = range(max(int(meets) - 60, 0), min(int(meets) + 60, int(end)))
    return Approach(
        link=Link(lanes[0].id, span.lane, (), "", "straight", "major"),
        line=line,
        starts=starts,
        edges=tuple(lane.edge for lane in lanes if lane.junction is None),
        stop=end,
        meets=meets,
        at=at,
        clear=clear_place(route, change.start - 10.0, at + 5.0, line, stretch),
        angle=0.0,
    )


def _lanes_before(town: Town, lane: Lane) -> list[Lane]:
    """Return the lanes that lead straight into a lane: the one before, and internal lanes."""
    ways = [link for link in town.links if link.target == lane.id and link.turn == "straight"]
    if not ways:
        return []
    return [town.lanes[name] for name in (ways[0].source, *ways[0].via)]
