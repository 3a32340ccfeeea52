"""A vehicle brought to where its way meets the ego's."""

import math
import random

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PATH_POSES, PATH_STEP
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.traffic import COMFORTABLE_BRAKING
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.conflicting_paths import Approach

LEAST_RUN = 35.0  # m before the meeting place at which a vehicle may be put out at the nearest
FROM_EGO = 45.0  # m from the ego at which a vehicle may be put out at the nearest
LAST_TURN, LAST_TURN_TIME = 0.2, 0.6  # m and s before its lane's end until which one may reroute
FROM_OTHERS = 14.0  # m kept to others on the lane when a vehicle is put out


class ConflictingVehicle:
    """A vehicle under command on an approach; mutable.

    Args:
        stage: The world.
        approach: The way it takes.
        vehicle: Its number.
    """

    def __init__(self, stage: HazardWorld, approach: Approach, vehicle: int) -> None:
        stage.command(vehicle)
        self.approach = approach
        self.vehicle = vehicle
        self._half = 0.5 * stage.kind_of(vehicle).length

    def front(self, stage: HazardWorld) -> float | None:
        """Return where its front is on the approach's line; None when it is not there."""
        return place_on(stage, self.approach, self.vehicle)

    def speed(self, stage: HazardWorld) -> float:
        """Return its speed, 0 when it is gone."""
        state = stage.state_of(self.vehicle)
        return 0.0 if state is None else state.speed

    def way_to_go(self, front: float) -> float:
        """Return the metres until its middle is where the ways meet."""
        return self.approach.meets + self._half - front

    def tell(self, stage: HazardWorld, front: float) -> None:
        """Tell who may know it where the vehicle is going, whatever the lights show."""
        stage.paths[self.vehicle] = poses_on(self.approach, front - self._half)

    def let_go(self, stage: HazardWorld) -> None:
        """Give it back to the traffic."""
        stage.hand_back(self.vehicle)


def place_on(stage: HazardWorld, approach: Approach, vehicle: int) -> float | None:
    """Return where on an approach's line a vehicle's front is; None when it is not there."""
    state = stage.state_of(vehicle)
    if state is None or state.lane not in approach.starts:
        return None
    return approach.starts[state.lane] + stage.along_lane(state)


def first_on(stage: HazardWorld, approach: Approach) -> int | None:
    """Return the vehicle that is next to leave an approach's lanes, if any is there."""
    for lane in reversed(incoming(approach)):
        present = stage.lane_state(lane)
        if present:
            return present[-1][0]
    return None


def incoming(approach: Approach) -> list[str]:
    """Return the lanes before the stop line, in order."""
    return [
        lane
        for lane, start in approach.starts.items()
        if start < approach.stop and not lane.startswith(":")
    ]


def put_out(
    stage: HazardWorld, approach: Approach, way: float, speed: float, draw: random.Random
) -> int | None:
    """Ask for a vehicle on an approach; None where its place is taken or too near.

    Args:
        stage: The world.
        approach: Where.
        way: Metres from its middle to the meeting place.
        speed: m/s that it has, at most the lane's limit.
        draw: Where it goes on behind the junction.
    """
    front = approach.meets + 0.5 * CAR.length - way
    if way < LEAST_RUN or front < CAR.length or front > approach.stop - 5.0:
        return None
    x, y = (float(np.interp(front, approach.along, approach.line[:, axis])) for axis in (0, 1))
    ego_x, ego_y, _ = stage.pose_at(stage.progress)
    if math.hypot(x - ego_x, y - ego_y) < FROM_EGO:
        return None
    for lane in incoming(approach):
        for _, position, _ in stage.lane_state(lane):
            if abs(approach.starts[lane] + position - front) < FROM_OTHERS:
                return None
    lane_id = [lane for lane in incoming(approach) if approach.starts[lane] <= front][-1]
    lane = stage.town.lanes[lane_id]
    if front > approach.starts[lane_id] + lane.length - 1.0:
        return None  # inside a junction
    at_lane = front - approach.starts[lane_id]
    room = math.sqrt(2.0 * COMFORTABLE_BRAKING * max(lane.length - at_lane - 5.0, 0.0))
    edges = approach.edges[approach.edges.index(lane.edge) :]
    onward = stage.onward(edges[-1], CAR.kind, draw)
    return stage.send(CAR, (*edges, *onward), lane, at_lane, min(speed, lane.speed_limit, room))


def reroute(stage: HazardWorld, approach: Approach, vehicle: int, draw: random.Random) -> bool:
    """Have a vehicle on an approach's lanes take its way; False where it cannot.

    A driver carries out what it last decided: one that is about to leave its lane would enter the
    junction on its old way, and SUMO dies of a vehicle that is on none of its route's lanes.
    """
    state = stage.state_of(vehicle)
    lane = None if state is None else stage.town.lanes.get(state.lane)
    if state is None or lane is None or lane.edge not in approach.edges[:-1]:
        return False
    left = lane.length - stage.along_lane(state)
    if left < LAST_TURN + LAST_TURN_TIME * state.speed:
        return False
    edges = approach.edges[approach.edges.index(lane.edge) :]
    onward = stage.onward(edges[-1], stage.kind_of(vehicle).kind, draw)
    return stage.reroute(vehicle, (*edges, *onward))


def poses_on(approach: Approach, along: float) -> Float[np.ndarray, "steps 3"]:
    """Return the poses of a privileged path on an approach's line from an arc length on."""
    line, at = approach.line, approach.along
    where = np.minimum(along + PATH_STEP * np.arange(PATH_POSES), at[-1])
    x, y = np.interp(where, at, line[:, 0]), np.interp(where, at, line[:, 1])
    before, after = np.maximum(where - 1.0, 0.0), np.minimum(where + 1.0, at[-1])
    dx = np.interp(after, at, line[:, 0]) - np.interp(before, at, line[:, 0])
    dy = np.interp(after, at, line[:, 1]) - np.interp(before, at, line[:, 1])
    return np.stack((x, y, np.arctan2(dy, dx)), axis=1)
