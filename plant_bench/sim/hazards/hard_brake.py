"""Hard brake: the leader brakes hard to a stop, waits for a moment and drives on.

The vehicle ahead of the ego is taken under command, or one is spawned out of sight and lets the ego
catch up. It keeps a safe gap while armed, and brakes no harder than a driver with reaction time can
compensate at that gap.
"""

import math
import random
from typing import NamedTuple

import numpy as np

from plant_bench.sim.hazards.behaviour import HoldsTraffic, parameter_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.driver_braking import BRAKING, REACTION, SPARE
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_LENGTH, ActorKind, EgoState

MIN_BRAKING = 6.0  # m/s2: gentler braking is no hazard
SLOWEST = 4.0  # m/s of the leader and of the ego; braking below is no hazard
SENT_AHEAD = 90.0  # m ahead of the ego at which a leader is spawned if there is none
SENT_SPEED = 0.35  # of the speed limit
LATE = 40.0  # m before and beyond the hazard's place where it may also happen
TRY_EVERY = 10  # ticks between two attempts to spawn a leader
LANE_HALF = 1.2  # m from the route within which a front is on the ego's lane
FAST_SHARE = 0.5  # of the speed limit; a slower leader brakes only beyond the place
GAIN = 0.25  # 1/s: how fast a gap is corrected
# Of the speed limit: a leader far ahead, near the ego, and one that must increase the gap
WAITING, ALONG, FASTEST = 0.35, 0.75, 1.2
AFAR = 1.5  # s of headway above the target that count as far
EARLY = 0.3  # s before the leader drives on; an ego that does not react arrives by then


class RouteVehicle(NamedTuple):
    """A vehicle that drives along the ego's route.

    Attributes:
        number: Actor id.
        front: Arc length of its front on the route, metres.
        offset: Lateral offset of its front from the route, positive to the left, metres.
        speed: m/s.
    """

    number: int
    front: float
    offset: float
    speed: float


class HardBrake(HoldsTraffic):
    """One leader that brakes; mutable.

    Parameters: `braking` (m/s2), `headway` (s, target before braking), `wait` (s of standstill).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        del world
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._braking = parameter_of(hazard, "braking", draw)
        self._headway = parameters.get("headway", draw.uniform(1.4, 1.7))
        self._wait = parameter_of(hazard, "wait", draw)
        self._leader: int | None = None
        self._stood: float | None = None

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Find a leader and control the gap; brake; drive on."""
        if self.phase is Phase.COMMITTED:
            self._hold(world)
        elif world.distance_to(self._at + LATE) < 0.0:
            reason = "no vehicle was ahead" if self._leader is None else "no fair moment to brake"
            self.end(world, Phase.VOID, reason)
        else:
            self._prepare(ego, world)

    def _prepare(self, ego: EgoState, world: HazardWorld) -> None:
        leader = leader_of(world)
        if leader is None:
            if self._leader is None or not world.on_road(self._leader):
                self._send(world)
            elif world.tick % TRY_EVERY == 0:
                world.drive(self._leader, SENT_SPEED * world.speed_limit_at(self._at))
            return
        if leader.number != self._leader:
            if self._leader is not None:
                world.hand_back(self._leader)
            self._leader = leader.number
            world.command(leader.number)
        gap = gap_to(world, leader)
        braking = self._fair_braking(ego, leader, gap)
        if braking is None or gap > self._farthest(ego, leader, braking):
            target = 2.0 + self._headway * ego.speed
            limit = world.speed_limit_at(leader.front)
            world.drive(leader.number, speed_for_gap(ego, gap, target, limit))
        elif self._is_place(world, leader, braking):
            world.brake_hard(leader.number, braking)
            self.phase = Phase.COMMITTED

    def _is_place(self, world: HazardWorld, leader: RouteVehicle, braking: float) -> bool:
        """Tell whether to brake here; a slow leader brakes only beyond the place."""
        stops = leader.front + leader.speed**2 / (2.0 * braking)
        fast = leader.speed > FAST_SHARE * world.speed_limit_at(leader.front)
        begin = self._at - LATE if fast else self._at
        here = begin <= stops <= self._at + LATE + CAR.length
        return here and world.lane_at(stops) is not None

    def _send(self, world: HazardWorld) -> None:
        front = world.progress + SENT_AHEAD
        lane = world.lane_at(front)
        if lane is not None and world.tick % TRY_EVERY == 0 and world.out_of_sight(front):
            self._leader = world.send_along(CAR, lane, front, SENT_SPEED * lane.speed_limit)

    def _fair_braking(self, ego: EgoState, leader: RouteVehicle, gap: float) -> float | None:
        """Return the leader's deceleration; None if it would be unfair or too gentle."""
        if min(ego.speed, leader.speed) < SLOWEST:
            return None
        stop = REACTION * ego.speed + ego.speed**2 / (2.0 * BRAKING)
        stop_distance = stop + SPARE - gap  # m: the leader's minimum stopping distance
        braking = min(
            self._braking, leader.speed**2 / (2.0 * stop_distance) if stop_distance > 0.0 else 99.0
        )
        return braking if braking >= MIN_BRAKING else None

    def _farthest(self, ego: EgoState, leader: RouteVehicle, braking: float) -> float:
        """Return the largest gap from which the ego arrives while the leader is stationary."""
        stands = leader.speed / braking + self._wait - EARLY
        return ego.speed * stands - leader.speed**2 / (2.0 * braking)

    def _hold(self, world: HazardWorld) -> None:
        state = world.state_of(self._leader) if self._leader is not None else None
        if state is None:
            self.end(world, Phase.DONE)
        elif state.speed < 0.1 and self._stood is None:
            self._stood = world.time
        elif self._stood is not None and world.time - self._stood > self._wait:
            self.end(world, Phase.DONE)

    def let_go(self, world: HazardWorld) -> None:
        """Return the leader to the traffic."""
        if self._leader is not None:
            world.hand_back(self._leader)


def leader_of(world: HazardWorld) -> RouteVehicle | None:
    """Return the next car or van ahead of the ego on its lane within sight."""
    front = world.progress + 0.5 * EGO_LENGTH
    for item in along_route(world):
        kind = world.kind_of(item.number)
        drives = kind.kind in (ActorKind.CAR, ActorKind.VAN)
        if drives and abs(item.offset) < LANE_HALF and item.front - 0.5 * kind.length > front:
            return item
    return None


def gap_to(world: HazardWorld, other: RouteVehicle) -> float:
    """Return the distance from the ego's front to a vehicle's rear along the route, metres."""
    return world.distance_to(other.front - world.kind_of(other.number).length)


def speed_for_gap(ego: EgoState, gap: float, target: float, limit: float) -> float:
    """Return the speed at which a leader approaches a target gap."""
    slowest = WAITING if gap > target + AFAR * ego.speed else ALONG
    speed = ego.speed + GAIN * (target - gap)
    return min(max(speed, slowest * limit), FASTEST * limit)


def along_route(world: HazardWorld, ahead: float = 80.0) -> list[RouteVehicle]:
    """Return the vehicles in sight that drive along the route, rearmost first.

    They are between 30 m behind and `ahead` metres ahead of the ego.
    """
    route, found = world.route, []
    first, last = np.searchsorted(route.along, (world.progress - 30.0, world.progress + ahead))
    points, headings = route.points[first : last + 1], route.headings[first : last + 1]
    seen = world.seen()
    places = np.array([state[:2] for state in seen.values()]).reshape(-1, 2)
    dx, dy = places[:, 0, None] - points[:, 0], places[:, 1, None] - points[:, 1]
    closest = (dx * dx + dy * dy).argmin(axis=1).tolist()
    yaws = headings.tolist()
    for (number, state), nearest in zip(seen.items(), closest, strict=True):
        yaw = yaws[nearest]
        if nearest in (0, len(points) - 1) or math.cos(state.yaw - yaw) < 0.8:
            continue
        x, y = state.x - float(points[nearest, 0]), state.y - float(points[nearest, 1])
        cos, sin = math.cos(yaw), math.sin(yaw)
        along = float(route.along[first + nearest]) + x * cos + y * sin
        found.append(RouteVehicle(number, along, y * cos - x * sin, state.speed))
    return sorted(found, key=lambda item: item.front)
