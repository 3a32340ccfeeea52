"""Merge under pressure: vehicles are beside the ego where its route changes lanes.

The first is beside the ego in the middle of the lane change; others may follow it in a stream.
"""

import math
import random

import numpy as np

from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.hazards.approach import (
    Approach,
    Rival,
    place_on,
    put_out,
    speed_to_arrive,
)
from plant_bench.sim.hazards.meeting import expected_arrival, time_to_go
from plant_bench.sim.hazards.stage import SPARE, Stage
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState
from plant_bench.world.town import Lane, Link, Town

BEFORE = 3.0  # m before the middle of the lane change where the ego begins to touch the lane
LEEWAY = 3.0  # m of slack, beyond what is spared, at which the vehicle is frozen
MISS = 0.4  # s between the arrivals of the two up to which they are beside each other
SLOWEST, FASTEST = 0.55, 1.4  # times the limit, of a vehicle that gets into place
MERGED = -25.0  # m to the lane change at which the ego has merged
RUN = 260.0  # m of lane, junctions included, in which a vehicle may get into place
LONGEST = 20.0  # s


class MergePressure:
    """A stream in the lane that the ego changes to; mutable.

    Parameters: `vehicles` (in all), `gap` (s from front to front).
    """

    def __init__(self, hazard: Hazard, stage: Stage, draw: random.Random) -> None:
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
        self.rival: Rival | None = None
        self.vehicles: list[int] = []
        if self._way is None:
            self.phase, self.reason = Phase.VOID, "the route changes no lane here"

    def step(self, ego: EgoState, stage: Stage) -> None:
        """Get a vehicle beside the ego, and let the stream go when the ego has merged."""
        way = self._way
        if way is None:
            return
        if self.rival is None:
            self._seek(ego, stage, way)
            return
        front = self.rival.front(stage)
        if self.phase is Phase.ARMED:
            self._adapt(ego, stage, self.rival, front)
        elif stage.distance_to(self._at) < MERGED or stage.time - self._begun > LONGEST:
            self._end(stage, Phase.DONE)
        elif front is not None:
            self._drive(stage, self.rival, front)
        if self.phase in (Phase.ARMED, Phase.COMMITTED):
            self._follow(stage, way, front)

    def _seek(self, ego: EgoState, stage: Stage, way: Approach) -> None:
        if not stage.avoidable(ego, self._at - BEFORE):
            self._end(stage, Phase.VOID, self._why)
            return
        time = expected_arrival(ego, stage, self._at)
        vehicle = self._present(stage, way, time)
        if vehicle is None:
            pace = self._draw.uniform(SLOWEST, FASTEST) * self._limit
            vehicle = put_out(stage, way, pace * time, pace, self._draw)
        if vehicle is not None:
            self.rival = Rival(stage, way, vehicle)

    def _present(self, stage: Stage, way: Approach, time: float) -> int | None:
        """Return the vehicle on the lane that would be beside the ego at the nearest pace."""
        best, least = None, math.inf
        for lane, start in way.starts.items():
            for vehicle, position, _ in stage.lane_state(lane):
                pace = (way.meets - start - position) / max(time, 0.1) / self._limit
                if SLOWEST < pace < FASTEST and abs(pace - 1.0) < least:
                    best, least = vehicle, abs(pace - 1.0)
        return None if best is None or stage.is_commanded(best) else best

    def _adapt(self, ego: EgoState, stage: Stage, rival: Rival, front: float | None) -> None:
        if front is None:
            gone = not stage.on_road(rival.vehicle)
            self._why = "SUMO did not put the vehicle in" if gone else "the vehicle left the lane"
            self._let_go(stage)
            return
        time = expected_arrival(ego, stage, self._at)
        speed = rival.speed(stage)
        to_go = rival.way_to_go(front)
        self._pace = min(speed_to_arrive(to_go, time, speed), FASTEST * self._limit)
        due = stage.slack(ego, self._at - BEFORE) <= SPARE + LEEWAY
        if due and not stage.avoidable(ego, self._at - BEFORE):
            self._end(stage, Phase.VOID, "the ego was too near to stop")
        elif due and abs(time_to_go(to_go, speed, self._pace) - time) > MISS:
            self._end(stage, Phase.VOID, "the vehicle could not be there in time")
        else:
            if due:
                self.phase, self._begun = Phase.COMMITTED, stage.time
            self._drive(stage, rival, front)

    def _drive(self, stage: Stage, rival: Rival, front: float) -> None:
        """Go on at the pace; rules are minded until the junctions lie behind."""
        free = front > rival.approach.starts[rival.approach.link.target]
        stage.drive(rival.vehicle, self._pace, lawless=free)
        if free:
            rival.tell(stage, front)

    def _follow(self, stage: Stage, way: Approach, front: float | None) -> None:
        places = [place_on(stage, way, vehicle) for vehicle in self.vehicles]
        for vehicle, place in zip(self.vehicles, places, strict=True):
            if place is not None:
                stage.drive(vehicle, self._pace)
        known = [place for place in (*places, front) if place is not None]
        if self._gaps and known:
            to_go = way.meets - min(known) + self._gaps[0] * self._limit
            vehicle = put_out(stage, way, to_go, self._limit, self._draw)
            if vehicle is not None:
                self._gaps.pop(0)
                stage.command(vehicle)
                self.vehicles.append(vehicle)

    def _let_go(self, stage: Stage) -> None:
        for vehicle in self.vehicles:
            stage.release(vehicle)
        self.vehicles.clear()
        if self.rival is not None:
            self.rival.let_go(stage)
            self.rival = None

    def _end(self, stage: Stage, phase: Phase, reason: str = "") -> None:
        self._let_go(stage)
        self.phase, self.reason = phase, reason


def lane_at(stage: Stage, at: float) -> Approach | None:
    """Return the lane that the route changes to at an arc length, as a way that meets the ego's."""
    route, town = stage.route, stage.town
    if not any(change.start - 5.0 <= at <= change.end + 5.0 for change in route.lane_changes):
        return None
    span = next((span for span in route.lanes if span.start >= at), None)
    if span is None or span.lane not in town.lanes:
        return None
    lanes = [town.lanes[span.lane]]
    while sum(lane.length for lane in lanes) < RUN and (before := _lanes_before(town, lanes[0])):
        lanes = before + lanes
    line = np.concatenate([lane.points[:, :2] for lane in lanes])
    line = line[np.concatenate(([True], np.hypot(*np.diff(line, axis=0).T) > 1e-3))]
    ends = np.cumsum([0.0, *(lane.length for lane in lanes)]).tolist()
    starts = {lane.id: start for lane, start in zip(lanes, ends[:-1], strict=True)}
    x, y, _ = stage.pose_at(at)
    where = np.arange(0.0, ends[-1], 1.0)
    on_line = [np.interp(where, arc_lengths(line), line[:, axis]) for axis in (0, 1)]
    meets = float(where[np.argmin(np.hypot(on_line[0] - x, on_line[1] - y))])
    link = Link(lanes[0].id, span.lane, (), "", "straight", "major")
    edges = tuple(lane.edge for lane in lanes if lane.junction is None)
    return Approach(link, line, starts, edges, ends[-1], meets, at, 0.0)


def _lanes_before(town: Town, lane: Lane) -> list[Lane]:
    """Return the lanes that lead into a lane straight on: the one before, and those between."""
    ways = [link for link in town.links if link.target == lane.id and link.turn == "straight"]
    if not ways:
        return []
    return [town.lanes[name] for name in (ways[0].source, *ways[0].via)]
