"""Merge under pressure: vehicles are beside the ego where its route changes lanes.

One is beside the ego in the middle of the lane change; those behind it follow in a row. All of them
insist on their lane while the ego is beside it, and give way when the ego's box is in it.
"""

import math
import random

import numpy as np

from plant_bench.geometry.box import corners
from plant_bench.geometry.polyline import arc_lengths, distances_to
from plant_bench.sim.hazards.arrival import expected_arrival, speed_to_arrive, time_to_go
from plant_bench.sim.hazards.behaviour import HoldsTraffic
from plant_bench.sim.hazards.conflicting_vehicle import ConflictingVehicle, place_on, put_out
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.conflicting_paths import Approach, clear_place, joined_line, lane_starts
from plant_bench.world.driver_braking import SPARE
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EgoState
from plant_bench.world.town import Lane, Link, Town

LEEWAY = 3.0  # m of slack, beyond what is spared, at which the vehicle is frozen
MISS = 0.5  # s between the arrivals of the two up to which they are beside each other
SLOWEST, FASTEST = 0.4, 1.4  # times the limit, of a vehicle that gets into place
MERGED = -25.0  # m to the lane change at which the ego has merged
RUN = 260.0  # m of lane, junctions included, in which a vehicle may get into place
LONGEST = 20.0  # s
LOOK = 4  # ticks between two looks at who is on the lane
ROW = 90.0  # m behind the vehicle beside the ego, in which others belong to its row
INSIDE = 1.3  # m from a lane's middle within which a box's corner is in the way of those on it
ROOM = 2.0  # m kept behind the ego
GIVING, HARDEST = 4.0, 8.0  # m/s2 with which vehicles give way, and at the most


class MergePressure(HoldsTraffic):
    """A row of vehicles in the lane that the ego changes to; mutable.

    Parameters: `vehicles` (put out in all), `gap` (s from front to front).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._why = "no vehicle could be there in time"
        self._draw = draw
        count = int(hazard.parameters.get("vehicles", draw.randint(1, 3)))
        gap = hazard.parameters.get("gap", 2.0)
        self._gaps = [gap * draw.uniform(1.0, 1.3) for _ in range(count - 1)]
        self._at = hazard.at
        self._limit = stage.speed_limit_at(hazard.at)
        self._pace = self._limit
        self._begun = math.inf
        self._way = lane_at(stage, hazard.at)
        self.rival: ConflictingVehicle | None = None
        self.vehicles: list[int] = []
        if self._way is None:
            self.phase, self.reason = Phase.VOID, "the route changes no lane here"

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Get a vehicle beside the ego, and let the row go when the ego has merged."""
        way = self._way
        if way is None:
            return
        if self.rival is None:
            self._seek(ego, stage, way)
            return
        front = self.rival.front(stage)
        if self.phase is Phase.ARMED:
            self._adapt(ego, stage, self.rival, front)
        elif stage.distance_to(self._at) < MERGED or self._is_stale(ego, stage, way):
            self.end(stage, Phase.DONE)
        if self.rival is not None:
            self._drive(ego, stage, self.rival, front)

    def _is_stale(self, ego: EgoState, stage: HazardWorld, way: Approach) -> bool:
        """Tell whether the row has pressed for long; one that gives way goes on to do so."""
        lasted = stage.time - self._begun
        return lasted > LONGEST and (lasted > 3.0 * LONGEST or place_inside(ego, way) is None)

    def _seek(self, ego: EgoState, stage: HazardWorld, way: Approach) -> None:
        if not stage.avoidable(ego, way.clear):
            self.end(stage, Phase.VOID, self._why)
            return
        if stage.tick % LOOK:
            return
        time = expected_arrival(ego, stage, self._at)
        vehicle = self._present(stage, way, time)
        if vehicle is None:
            pace = self._draw.uniform(0.6, 1.2) * self._limit
            vehicle = put_out(stage, way, pace * time, pace, self._draw)
        if vehicle is not None:
            self.rival = ConflictingVehicle(stage, way, vehicle)

    def _present(self, stage: HazardWorld, way: Approach, time: float) -> int | None:
        """Return the vehicle on the lane that gets beside the ego with the least change of pace."""
        best, least = None, math.inf
        for lane, start in way.starts.items():
            for vehicle, position, speed in stage.lane_state(lane):
                to_go = way.meets + 0.5 * stage.kind_of(vehicle).length - start - position
                pace = speed_to_arrive(to_go, time, speed)
                fits = SLOWEST * self._limit < pace < FASTEST * self._limit
                if fits and abs(pace - speed) < least and not stage.is_commanded(vehicle):
                    best, least = vehicle, abs(pace - speed)
        return best

    def _adapt(
        self, ego: EgoState, stage: HazardWorld, rival: ConflictingVehicle, front: float | None
    ) -> None:
        if front is None:
            gone = not stage.on_road(rival.vehicle)
            self._why = "SUMO did not put the vehicle in" if gone else "the vehicle left the lane"
            self.let_go(stage)
            return
        time = expected_arrival(ego, stage, self._at)
        speed, to_go = rival.speed(stage), rival.way_to_go(front)
        self._pace = min(speed_to_arrive(to_go, time, speed), FASTEST * self._limit)
        clear = rival.approach.clear
        meets = abs(time_to_go(to_go, speed, self._pace) - time) <= MISS
        if not stage.avoidable(ego, clear):
            why = (
                "the ego was too near to stop"
                if meets
                else "the vehicle could not be there in time"
            )
            self.end(stage, Phase.VOID, why)
        elif meets and stage.slack(ego, clear) <= SPARE + LEEWAY:
            self.phase, self._begun = Phase.COMMITTED, stage.time
        elif not meets:
            self._why = "the vehicle could not be there in time"
            if stage.tick % LOOK == 0 and self._present(stage, rival.approach, time) is not None:
                self.let_go(stage)

    def _drive(
        self, ego: EgoState, stage: HazardWorld, rival: ConflictingVehicle, front: float | None
    ) -> None:
        """Drive the row; rules are minded until the junctions lie behind."""
        way, inside = rival.approach, None
        if self.phase is Phase.COMMITTED:
            inside = place_inside(ego, way)
        if front is not None:
            free = front > way.starts[way.link.target]
            self._go(stage, rival.vehicle, front, inside, lawless=free)
            if free:
                rival.tell(stage, front)
        places = {one: place_on(stage, way, one) for one in self.vehicles}
        for vehicle, place in places.items():
            if place is not None:
                self._go(stage, vehicle, place, inside, lawless=False)
        if front is not None and stage.tick % LOOK == 0:
            self._follow(stage, way, [front, *(x for x in places.values() if x is not None)])

    def _go(
        self, stage: HazardWorld, vehicle: int, front: float, inside: float | None, *, lawless: bool
    ) -> None:
        """Let a vehicle go on at the row's pace, or give way to an ego inside its lane."""
        if inside is None or front > inside + EGO_LENGTH:
            stage.drive(vehicle, self._pace, lawless=lawless)
            return
        state = stage.state_of(vehicle)
        speed = 0.0 if state is None else state.speed
        room = max(inside - ROOM - front, 0.1)
        if speed**2 / (2.0 * room) > GIVING:
            stage.drive(vehicle, 0.0)
            stage.brake_hard(vehicle, HARDEST)
        else:
            stage.drive(vehicle, min(self._pace, math.sqrt(2.0 * GIVING * room)))

    def _follow(self, stage: HazardWorld, way: Approach, known: list[float]) -> None:
        """Take those behind into the row; put out the next of it."""
        first = known[0]
        for lane, start in way.starts.items():
            for vehicle, position, _ in stage.lane_state(lane):
                if -ROW < start + position - first < 0.0 and not stage.is_commanded(vehicle):
                    self._join(stage, vehicle)
        if self._gaps:
            to_go = way.meets - min(known) + self._gaps[0] * self._limit
            vehicle = put_out(stage, way, to_go, self._limit, self._draw)
            if vehicle is not None:
                self._gaps.pop(0)
                self._join(stage, vehicle)

    def _join(self, stage: HazardWorld, vehicle: int) -> None:
        stage.command(vehicle)
        self.vehicles.append(vehicle)

    def let_go(self, stage: HazardWorld) -> None:
        """Give the whole row back to the traffic."""
        for vehicle in self.vehicles:
            stage.release(vehicle)
        self.vehicles.clear()
        if self.rival is not None:
            self.rival.let_go(stage)
            self.rival = None


def place_inside(ego: EgoState, way: Approach) -> float | None:
    """Return where on a lane the ego's rear is when its box is in the way there; else None."""
    box = corners(np.array([ego.pose]), np.array([EGO_EXTENT]))[0]
    if distances_to(way.line, box).min() > INSIDE:
        return None
    where = np.arange(0.0, float(way.along[-1]), 1.0)
    x, y = (np.interp(where, way.along, way.line[:, axis]) for axis in (0, 1))
    return float(where[np.argmin(np.hypot(x - ego.x, y - ego.y))]) - 0.5 * EGO_LENGTH


def lane_at(stage: HazardWorld, at: float) -> Approach | None:
    """Return the lane that the route changes to at an arc length, as a way that meets the ego's."""
    route, town = stage.route, stage.town
    change = next((c for c in route.lane_changes if c.start - 5.0 <= at <= c.end + 5.0), None)
    span = next((span for span in route.lanes if span.start >= at), None)
    if change is None or span is None or span.lane not in town.lanes:
        return None
    lanes = [town.lanes[span.lane]]
    while sum(lane.length for lane in lanes) < RUN and (before := _lanes_before(town, lanes[0])):
        lanes = before + lanes
    line, starts = joined_line(lanes), lane_starts(lanes)
    end = starts[span.lane] + lanes[-1].length
    x, y, _ = stage.pose_at(at)
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
    """Return the lanes that lead into a lane straight on: the one before, and those between."""
    ways = [link for link in town.links if link.target == lane.id and link.turn == "straight"]
    if not ways:
        return []
    return [town.lanes[name] for name in (ways[0].source, *ways[0].via)]
