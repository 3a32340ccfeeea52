"""Crossing: a pedestrian or cyclist crosses the road (CARLA types 3 and 4), maybe behind a van.

The walker starts when its time to the ego's lane equals the ego's earliest arrival, so that it
conflicts with an ego that does not react. It starts beside the road, and far enough from the ego's
lane for a driver with reaction time to stop. It waits beside the road before and after, until the
ego is far away. It does not step in front of other vehicles; after they have passed, it is faster.
"""

import math
import random

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.box import corners
from plant_bench.geometry.polyline import distance_to
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.sumo import VehicleState
from plant_bench.sim.vehicle_types import RIDER, VAN, WALKER
from plant_bench.world.crossing_distance import FARTHEST_START, SPEED_SPREAD, meets_at, needed_start
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_WIDTH, TICK, EgoState
from plant_bench.world.town import Lane

AHEAD_OF_TIME = 0.3  # s by which the walker is early, so that the ego does not pass behind it
MIN_WAIT = 3.0  # s that the walker is present before it moves
MAX_KERB = 16.0  # m beside the ego's path within which the road's edge is searched
FROM_KERB = 0.7  # m beside the road where the walker waits
DELAYED_FACTOR = 1.35  # speed factor of a walker that had to let others pass, at most
WIDE_ROAD_FACTOR = 1.6  # speed factor of a walker on a wide road, at most
PASSED = 30.0  # m behind the ego at which all actors are removed
VAN_BESIDE = 3.1  # m from the ego's path to the van's centre, at least
VAN_FROM_KERB = 1.2  # m beside the road to the van's centre
VAN_CLEARANCE = 0.15  # m between the van and any lane: SUMO's drivers stop behind a van on theirs
VAN_STEP, VAN_STEPS = 0.05, 40  # m, and how many steps the van is moved aside to be clear
OUTLINE_STEP = 0.5  # m between the points of the van's sides that are checked
VAN_BEFORE = 5.0  # m before the walker
BEFORE, BEHIND = 1.5, 0.5  # s between the walker and a vehicle after or before it
BODY = 6.0  # m, a vehicle's length with a margin


class Crossing:
    """One pedestrian or cyclist from the right or the left; mutable.

    Parameters: `speed` (m/s), `side` (-1 from the right, 1 from the left), `rider` (1 for a
    bicycle), `hidden` (1 for a parked van before it).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._kind = RIDER if parameters.get("rider", 0.0) else WALKER
        self._speed = parameters.get("speed", 1.4)
        self._speed *= draw.uniform(1.0 - SPEED_SPREAD, 1.0 + SPEED_SPREAD)
        self._side = 1.0 if parameters.get("side", -1.0) > 0 else -1.0
        self._hidden = bool(parameters.get("hidden", 0.0))
        limit = world.speed_limit_at(hazard.at)
        self._enters = meets_at(self._kind.length)
        reach = 0.5 * self._kind.length + FROM_KERB
        self._near, far = (_kerb(world, hazard.at, side) for side in (self._side, -self._side))
        required = min(needed_start(self._speed, limit, self._kind.length), FARTHEST_START)
        self._offset = max(required, self._near + reach)
        self._speed *= min(max(self._offset / required, 1.0), WIDE_ROAD_FACTOR)
        self._fastest = self._speed * DELAYED_FACTOR
        self._end_offset = -max(far + reach, self._enters + 1.0)
        self._since = world.time
        self._held = False
        self._actors: list[int] = []

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Spawn the walker, start it in time, and remove it behind the ego."""
        if world.distance_to(self._at + VAN.length) < -PASSED:
            self._end(world)
        elif not self._actors:
            self._appear(world)
        elif self.phase is Phase.COMMITTED and self._offset > self._end_offset:
            self._offset -= self._speed * TICK
            speed = self._speed if self._offset > self._end_offset else 0.0
            world.place(self._actors[0], *self._pose(world), speed)
        elif self.phase is Phase.ARMED and not self.reason:
            self._wait(ego, world)

    def _wait(self, ego: EgoState, world: HazardWorld) -> None:
        """Start in time, or once others have passed; if it is too late, stay beside the road."""
        if not world.avoidable(ego, self._at - 0.5 * self._kind.width):
            self.reason = "others were in the way" if self._held else "the ego was too near to stop"
            return
        distance = self._offset - self._enters
        time = world.soonest_arrival(ego, self._at) - AHEAD_OF_TIME
        if world.time - self._since < MIN_WAIT or time > distance / self._speed:
            return
        speed = min(distance / max(time, 0.1), self._fastest)
        if self._endangers(ego, world, speed):
            self._held = True
        else:
            self._speed, self.phase = speed, Phase.COMMITTED

    def _endangers(self, ego: EgoState, world: HazardWorld, pace: float) -> bool:
        """Tell whether a vehicle that drives straight on would conflict with the walker.

        Vehicles right behind the ego are left out, because the ego stops first.
        """
        x, y, _ = world.pose_at(self._at)
        _, _, yaw = self._pose(world)
        cos, sin = math.cos(yaw), math.sin(yaw)
        for number, state in world.seen().items():
            across = -math.sin(state.yaw) * cos + math.cos(state.yaw) * sin
            if number in self._actors or abs(across) < 0.3 or _follows(state, ego):
                continue
            dx, dy = x - state.x, y - state.y
            # Where both paths intersect: metres along the vehicle's, and along the walker's.
            own = (cos * dy - sin * dx) / -across
            place = (math.cos(state.yaw) * dy - math.sin(state.yaw) * dx) / -across
            walked = place + self._offset
            if not 0.0 < walked < self._offset - self._end_offset or own < -BODY:
                continue
            speed = max(state.speed, 0.5)
            meets = walked / pace
            if own / speed - BEFORE < meets < (own + BODY) / speed + BEHIND:
                return True
        return False

    def _appear(self, world: HazardWorld) -> None:
        x, y, yaw = self._pose(world)
        if not world.is_free(x, y, 2.0):
            return
        if self._hidden:
            place = self._van_place(world)
            if place is not None and world.is_free(*place[:2], 3.0):
                self._actors.append(world.put(VAN, *place))
        self._actors.insert(0, world.put(self._kind, x, y, yaw))
        self._since = world.time

    def _van_place(self, world: HazardWorld) -> tuple[float, float, float] | None:
        """Return the pose of the van beside the road; None if it would overlap a lane."""
        at = self._at - VAN_BEFORE
        x, y, yaw = world.pose_at(at)
        lanes = _lanes_around(world, at)
        for step in range(VAN_STEPS):
            aside = max(VAN_BESIDE, self._near + VAN_FROM_KERB) + step * VAN_STEP
            across = self._side * aside
            pose = x - across * math.sin(yaw), y + across * math.cos(yaw), yaw
            outline = _outline(pose, VAN.length, VAN.width)
            if all(_is_clear(lane, outline) for lane in lanes):
                return pose
        return None

    def _pose(self, world: HazardWorld) -> tuple[float, float, float]:
        x, y, heading = world.pose_at(self._at)
        aside = self._side * self._offset
        yaw = heading - self._side * 0.5 * math.pi
        return x - aside * math.sin(heading), y + aside * math.cos(heading), yaw

    def _end(self, world: HazardWorld) -> None:
        for actor in self._actors:
            world.remove(actor)
        if self.phase is Phase.COMMITTED:
            self.phase = Phase.DONE
        else:
            self.phase = Phase.VOID
            self.reason = self.reason or "the place was occupied"


def _follows(state: VehicleState, ego: EgoState) -> bool:
    """Tell whether a vehicle is behind the ego on its lane."""
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = state.x - ego.x, state.y - ego.y
    behind = cos * dx + sin * dy < 0.0 and abs(cos * dy - sin * dx) < EGO_WIDTH
    return behind and math.cos(state.yaw - ego.yaw) > 0.8


def _kerb(world: HazardWorld, at: float, side: float) -> float:
    """Return the distance from the ego's path to the road's edge, oncoming lanes included."""
    x, y, heading = world.pose_at(at)
    lanes = _lanes_around(world, at)
    road = 0.0
    for aside in np.arange(0.25, MAX_KERB, 0.25):
        px, py = x - side * aside * math.sin(heading), y + side * aside * math.cos(heading)
        inside = (distance_to(lane.points[:, :2], px, py) < 0.5 * lane.width for lane in lanes)
        if any(inside):
            road = float(aside)
        elif aside > road + 1.0:
            break
    return road


def _lanes_around(world: HazardWorld, at: float) -> list[Lane]:
    """Return the lanes near the route's place `at`, on its level."""
    x, y, _ = world.pose_at(at)
    height = float(np.interp(at, world.route.along, world.route.elevations))
    return [
        lane
        for lane in world.town.lanes.values()
        if np.abs(lane.points[:, 2] - height).min() < 3.0
        and distance_to(lane.points[:, :2], x, y) < MAX_KERB + lane.width
    ]


def _outline(
    pose: tuple[float, float, float], length: float, width: float
) -> Float[np.ndarray, "points 2"]:
    """Return points along a box's sides, at most `OUTLINE_STEP` apart."""
    first = corners(np.array([pose]), np.array([[length, width]]))[0]
    share = np.linspace(0.0, 1.0, math.ceil(length / OUTLINE_STEP), endpoint=False)[:, None]
    following = np.roll(first, -1, axis=0)
    return np.concatenate([a + share * (b - a) for a, b in zip(first, following, strict=True)])


def _is_clear(lane: Lane, outline: Float[np.ndarray, "points 2"]) -> bool:
    """Tell whether points are off a lane, with `VAN_CLEARANCE`."""
    away = min(distance_to(lane.points[:, :2], x, y) for x, y in outline.tolist())
    return away > 0.5 * lane.width + VAN_CLEARANCE
