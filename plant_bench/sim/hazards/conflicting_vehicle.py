"""Controls a vehicle so that it arrives at a conflict point together with the ego."""

import math
import random

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PATH_POSES, PATH_STEP
from plant_bench.sim.hazards.hazard_world import LAST_TURN, LAST_TURN_TIME, HazardWorld
from plant_bench.sim.traffic import COMFORTABLE_BRAKING
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.conflicting_paths import Approach

MIN_RUN = 35.0  # m before the conflict point; no vehicle is spawned nearer
FROM_EGO = 45.0  # m from the ego; no vehicle is spawned nearer
FROM_OTHERS = 14.0  # m between a spawned vehicle and others on the lane


class ConflictingVehicle:
    """A vehicle under command on an approach; mutable.

    Args:
        world: The world.
        approach: The approach it drives on.
        vehicle: Its actor id.
    """

    def __init__(self, world: HazardWorld, approach: Approach, vehicle: int) -> None:
        world.command(vehicle)
        self.approach = approach
        self.vehicle = vehicle
        self._half = 0.5 * world.kind_of(vehicle).length

    def front(self, world: HazardWorld) -> float | None:
        """Return the arc length of its front on the approach; None if it is elsewhere."""
        return place_on(world, self.approach, self.vehicle)

    def speed(self, world: HazardWorld) -> float:
        """Return its speed, 0 if it no longer exists."""
        state = world.state_of(self.vehicle)
        return 0.0 if state is None else state.speed

    def way_to_go(self, front: float) -> float:
        """Return the distance from its centre to the conflict point, metres."""
        return self.approach.meets + self._half - front

    def publish_path(self, world: HazardWorld, front: float) -> None:
        """Publish the vehicle's path as privileged information, whatever the lights show."""
        world.paths[self.vehicle] = poses_on(self.approach, front - self._half)

    def let_go(self, world: HazardWorld) -> None:
        """Return it to the traffic."""
        world.hand_back(self.vehicle)


def place_on(world: HazardWorld, approach: Approach, vehicle: int) -> float | None:
    """Return the arc length of a vehicle's front on an approach; None if it is elsewhere."""
    state = world.state_of(vehicle)
    if state is None or state.lane not in approach.starts:
        return None
    return approach.starts[state.lane] + world.along_lane(state)


def first_on(world: HazardWorld, approach: Approach) -> int | None:
    """Return the vehicle that will leave an approach's lanes next, if there is one."""
    for lane in reversed(incoming(approach)):
        present = world.lane_state(lane)
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


def spawn_on(
    world: HazardWorld, approach: Approach, distance: float, speed: float, draw: random.Random
) -> int | None:
    """Spawn a vehicle on an approach; None if the place is occupied or too near.

    Args:
        world: The world.
        approach: The approach.
        distance: Distance from its centre to the conflict point, metres.
        speed: Its speed, at most the lane's limit, m/s.
        draw: Draws its route behind the junction.
    """
    front = approach.meets + 0.5 * CAR.length - distance
    if distance < MIN_RUN or front < CAR.length or front > approach.stop - 5.0:
        return None
    x, y = (float(np.interp(front, approach.along, approach.line[:, axis])) for axis in (0, 1))
    ego_x, ego_y, _ = world.pose_at(world.progress)
    if math.hypot(x - ego_x, y - ego_y) < FROM_EGO:
        return None
    for lane in incoming(approach):
        for _, position, _ in world.lane_state(lane):
            if abs(approach.starts[lane] + position - front) < FROM_OTHERS:
                return None
    lane_id = [lane for lane in incoming(approach) if approach.starts[lane] <= front][-1]
    lane = world.town.lanes[lane_id]
    if front > approach.starts[lane_id] + lane.length - 1.0:
        return None  # inside a junction
    at_lane = front - approach.starts[lane_id]
    brakable_speed = math.sqrt(2.0 * COMFORTABLE_BRAKING * max(lane.length - at_lane - 5.0, 0.0))
    edges = approach.edges[approach.edges.index(lane.edge) :]
    onward = world.onward(edges[-1], CAR.kind, draw)
    return world.send(
        CAR, (*edges, *onward), lane, at_lane, min(speed, lane.speed_limit, brakable_speed)
    )


def reroute(world: HazardWorld, approach: Approach, vehicle: int, draw: random.Random) -> bool:
    """Reroute a vehicle on an approach's lanes through its junction; False if that is impossible.

    SUMO carries out a driver's last decision: a vehicle about to leave its lane would enter the
    junction on its old route, and SUMO crashes if a vehicle is on no lane of its route.
    """
    state = world.state_of(vehicle)
    lane = None if state is None else world.town.lanes.get(state.lane)
    if state is None or lane is None or lane.edge not in approach.edges[:-1]:
        return False
    left = lane.length - world.along_lane(state)
    if left < LAST_TURN + LAST_TURN_TIME * state.speed:
        return False
    edges = approach.edges[approach.edges.index(lane.edge) :]
    onward = world.onward(edges[-1], world.kind_of(vehicle).kind, draw)
    return world.reroute(vehicle, (*edges, *onward))


def poses_on(approach: Approach, along: float) -> Float[np.ndarray, "steps 3"]:
    """Return the poses of a privileged path on an approach's line from an arc length on."""
    line, at = approach.line, approach.along
    where = np.minimum(along + PATH_STEP * np.arange(PATH_POSES), at[-1])
    x, y = np.interp(where, at, line[:, 0]), np.interp(where, at, line[:, 1])
    before, after = np.maximum(where - 1.0, 0.0), np.minimum(where + 1.0, at[-1])
    dx = np.interp(after, at, line[:, 0]) - np.interp(before, at, line[:, 0])
    dy = np.interp(after, at, line[:, 1]) - np.interp(before, at, line[:, 1])
    return np.stack((x, y, np.arctan2(dy, dx)), axis=1)
