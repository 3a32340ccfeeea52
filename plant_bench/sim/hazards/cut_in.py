"""Cut-in: a vehicle changes from the next lane into a small gap ahead of the ego, and brakes.

It follows its own line from the moment it is taken under command, because SUMO's drivers change
lanes on their own: beside the ego's lane until it has the target gap, then onto the ego's lane,
where it is returned to SUMO.
"""

import random

import numpy as np

from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.hazards.behaviour import HoldsTraffic, parameter_of
from plant_bench.sim.hazards.hard_brake import LANE_HALF, RouteVehicle, along_route
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.driver_braking import BRAKING, REACTION
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_LENGTH, TICK, ActorKind, EgoState
from plant_bench.world.town import Lane

SLOWEST = 4.0  # m/s of both; no cut-in below
TOLERANCE = 2.5  # m from the target gap
MIN_GAP_LEFT = 2.0  # m left once a driver with reaction time has braked
LATE = 40.0  # m before and beyond the hazard's place where it may also happen
NEAREST, FARTHEST = -8.0, 40.0  # m ahead of the ego within which a vehicle is taken
SENT_AHEAD = 88.0  # m ahead of the ego at which a vehicle is spawned if none is there
SENT_BEFORE = 30.0  # m before the hazard's place at which a vehicle is spawned
WAITS_AT = 10.0  # m before the hazard's place where a spawned vehicle waits for the ego
SENT_SPEED = 0.35  # of the speed limit
AFAR = 3.5  # s of headway, and 10 m, before which it waits
CONTACT = 3.6  # s until an ego that does not react hits the slower vehicle
TRY_EVERY = 10  # ticks between two attempts to spawn a vehicle
GAIN, CLOSING = 0.4, (-3.0, 7.0)  # 1/s and m/s: control of the gap
FASTEST = 1.2  # of the speed limit
SLOWER = 0.93  # of the ego's speed: target speed during the lane change
ACCELERATIONS = (-3.0, 2.5)  # m/s2, range
KEPT = 0.55  # of its speed: left after braking
LEADER_BRAKING = 4.5  # m/s2 with which it brakes for its own leader
GAP, HEADWAY = 3.0, 0.5  # m, and s of its speed, that are free ahead of it
BLOCK_END = 25.0  # m before its edge's end; it is released there


class CutIn(HoldsTraffic):
    """One vehicle that cuts in; mutable.

    Parameters: `gap` (m), `duration` (s of the lane change), `braking` (m/s2 after it), `side` (1
    from the left, -1 from the right, 0 for either).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._gap = parameter_of(hazard, "gap", draw)
        self._duration = parameter_of(hazard, "duration", draw)
        self._braking = parameter_of(hazard, "braking", draw)
        self._adjacent, self._side = _adjacent_lane(world, hazard, draw)
        self._other: int | None = None
        self._sent = 0.0  # arc length of the front of a vehicle not yet inserted by SUMO
        self._centre = self._speed = self._target_speed = self._moved = 0.0
        self._line, self._line_along, self._from = np.zeros((2, 2)), np.zeros(2), 0.0

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Find a vehicle and control the gap; change lanes and brake; release it."""
        if self.phase is Phase.COMMITTED:
            self._move(world)
        elif self._adjacent is None:
            self.end(world, Phase.VOID, "there is no adjacent lane")
        elif world.distance_to(self._at + LATE) < 0.0:
            reason = "no vehicle was beside" if self._other is None else "no fair moment to cut in"
            self.end(world, Phase.VOID, reason)
        elif self._other is not None and not world.on_road(self._other):
            world.remove(self._other)
            self._other, self._sent = None, 0.0
        elif self._other is None:
            self._find(ego, world, self._adjacent)
        elif self._sent:
            self._take(world, self._other, self._sent)
        else:
            self._prepare(ego, world, self._adjacent)

    def _find(self, ego: EgoState, world: HazardWorld, lane: Lane) -> None:
        """Take the vehicle nearest to the target gap, or spawn one."""
        states = world.seen()
        near = {
            abs(world.distance_to(item.front - EGO_LENGTH) - self._gap): item
            for item in along_route(world)
            if states[item.number].lane == lane.id
            and world.kind_of(item.number).kind in (ActorKind.CAR, ActorKind.VAN)
            and NEAREST < world.distance_to(item.front - EGO_LENGTH) < FARTHEST
            and world.may_be_placed(item.number, states[item.number])
        }
        if near:
            item = near[min(near)]
            world.command(item.number)
            world.keep_lane(item.number)
            self._take(world, item.number, item.front)
        elif world.tick % TRY_EVERY == 0 and ego.speed > SLOWEST:
            front = max(world.progress + SENT_AHEAD, self._at - SENT_BEFORE)
            here = world.lane_at(front + BLOCK_END)
            if here is not None and here.edge == lane.edge and world.out_of_sight(front):
                speed = SENT_SPEED * lane.speed_limit
                self._other = world.send_along(CAR, lane, front, speed)
                self._sent = front
                if self._other is not None:
                    world.keep_lane(self._other)

    def _take(self, world: HazardWorld, vehicle: int, front: float) -> None:
        state = world.state_of(vehicle)
        if state is None:
            return
        self._other, self._sent = vehicle, 0.0
        self._centre = front - 0.5 * world.kind_of(vehicle).length
        self._speed = state.speed
        x, y, yaw = world.pose_at(front)
        aside = (state.y - y) * np.cos(yaw) - (state.x - x) * np.sin(yaw)
        self._plan_line(world, np.full(200, aside))
        self._advance(world, 0.0, 0.0)

    def _plan_line(self, world: HazardWorld, aside: np.ndarray) -> None:
        """Compute the line that it follows from offsets to the route at each metre ahead."""
        route, self._from = world.route, self._centre
        at = self._from + np.arange(len(aside))
        x, y, yaw = (
            np.interp(at, route.along, column)
            for column in (route.points[:, 0], route.points[:, 1], route.headings)
        )
        self._line = np.stack((x - aside * np.sin(yaw), y + aside * np.cos(yaw)), axis=1)
        self._line_along = arc_lengths(self._line)
        self._aside = float(aside[0])

    def _prepare(self, ego: EgoState, world: HazardWorld, lane: Lane) -> None:
        here = world.lane_at(self._centre + BLOCK_END)
        if here is None or here.edge != lane.edge:
            self.let_go(world)
            return
        around = along_route(world, 140.0)
        gap = world.distance_to(self._rear(world))
        early = world.distance_to(self._at - LATE) > gap + 2.0 * ego.speed
        if not early and self._ready(ego, gap) and self._is_free(world, around, 0.0):
            self._advance(world, 0.0, 0.0)
            self._target_speed = min(SLOWER * ego.speed, self._speed + 1.0)
            at = np.arange(200.0)
            share = np.clip(at / max(self._duration * self._target_speed, 8.0), 0.0, 1.0)
            aside = 1.0 - share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
            self._plan_line(world, self._aside * aside)
            self.phase = Phase.COMMITTED
            return
        closing = min(max(GAIN * (gap - self._gap), CLOSING[0]), CLOSING[1])
        target_speed = min(max(ego.speed - closing, SLOWEST), FASTEST * lane.speed_limit)
        if gap > AFAR * ego.speed + 10.0:
            arrived = self._centre > self._at - WAITS_AT
            target_speed = 0.0 if arrived else SENT_SPEED * lane.speed_limit
        acceleration = min(
            max((target_speed - self._speed) / TICK, ACCELERATIONS[0]), ACCELERATIONS[1]
        )
        if not self._is_free(world, around, self._aside):
            acceleration = -LEADER_BRAKING
        self._advance(world, acceleration, 0.0)

    def let_go(self, world: HazardWorld) -> None:
        """Return the vehicle to the traffic."""
        if self._other is not None:
            world.hand_back(self._other)
        self._other = None

    def _rear(self, world: HazardWorld) -> float:
        return self._centre - 0.5 * world.kind_of(self._other or 0).length

    def _ready(self, ego: EgoState, gap: float) -> bool:
        """Tell whether it may change lanes: at the gap, and avoidable with reaction time."""
        closing = max(ego.speed - min(SLOWER * ego.speed, self._speed), 0.0)
        near = abs(gap - self._gap) < TOLERANCE or self._gap < gap < CONTACT * closing
        if min(ego.speed, self._speed) < SLOWEST or not near:
            return False
        unaware = 0.5 * self._duration + REACTION
        left = gap - closing * unaware - 0.5 * max(ego.acceleration, 0.0) * unaware**2
        return left - closing**2 / (2.0 * BRAKING) > MIN_GAP_LEFT

    def _is_free(self, world: HazardWorld, around: list[RouteVehicle], aside: float) -> bool:
        """Tell whether a lane is free from the ego's front to a margin ahead of the vehicle."""
        ego = world.progress + 0.5 * EGO_LENGTH
        front = 2.0 * self._centre - self._rear(world)
        begin = ego if abs(aside) < LANE_HALF else front
        return not any(
            abs(item.offset - aside) < LANE_HALF
            and item.number != self._other
            and item.front > begin
            and item.front - world.kind_of(item.number).length < front + GAP + HEADWAY * self._speed
            for item in around
        )

    def _move(self, world: HazardWorld) -> None:
        if self._other is None or not world.on_road(self._other):
            self.end(world, Phase.DONE)
            return
        self._moved += TICK
        slowest = KEPT * self._target_speed
        acceleration = min(max((self._target_speed - self._speed) / TICK, -1.5), 1.5)
        if self._moved > self._duration:
            acceleration = -self._braking
        if not self._is_free(world, along_route(world, 140.0), 0.0):
            acceleration, slowest = -LEADER_BRAKING, 0.0
        self._advance(world, acceleration, slowest)
        if self._moved > self._duration + 0.5 and self._speed <= KEPT * self._target_speed:
            self.end(world, Phase.DONE)

    def _advance(self, world: HazardWorld, acceleration: float, slowest: float) -> None:
        if self._other is not None:
            self._speed = max(self._speed + acceleration * TICK, min(slowest, self._speed))
            self._centre += self._speed * TICK
            along = self._centre - self._from
            world.place_along(self._other, self._line, self._line_along, along, self._speed)


def _adjacent_lane(
    world: HazardWorld, hazard: Hazard, draw: random.Random
) -> tuple[Lane | None, float]:
    """Return the lane and the side from which the vehicle comes."""
    lane, side = world.lane_at(hazard.at), hazard.parameters.get("side", 0.0)
    beside = {} if lane is None else {1.0: lane.left, -1.0: lane.right}
    known = [(name, key) for key, name in beside.items() if name and side in (0.0, key)]
    if not known:
        return None, 0.0
    name, chosen = draw.choice(known)
    return world.town.lanes[name], chosen
