"""A vehicle in the neighbour lane moves in front of the ego with a small gap and brakes slightly.

It follows a line of its own from the moment it is taken, since SUMO's drivers change lanes as they
please: beside the ego's lane until it has come to the wanted gap, then onto the ego's lane, where
it is given back to SUMO.
"""

import random

import numpy as np

from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.hazards.behaviour import HoldsTraffic, number_of
from plant_bench.sim.hazards.hard_brake import LANE_HALF, Neighbour, along_route
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.driver_braking import BRAKING, REACTION
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_LENGTH, TICK, ActorKind, EgoState
from plant_bench.world.town import Lane

SLOWEST = 4.0  # m/s of both, below which nobody cuts in
TOLERANCE = 2.5  # m from the wanted gap
LEAST_LEFT = 2.0  # m that a surprised driver must have left
LATE = 40.0  # m before and beyond the hazard's place where it may happen too
NEAREST, FARTHEST = -8.0, 40.0  # m before the ego within which somebody is taken
SENT_AHEAD = 88.0  # m before the ego at which one is sent when there is nobody
SENT_BEFORE = 30.0  # m before the hazard's place at which one is sent
WAITS_AT = 10.0  # m before the hazard's place where one who was sent waits for the ego
SENT_SPEED = 0.35  # of the speed limit
AFAR = 3.5  # s of headway, and 10 m, before which it waits
CONTACT = 3.6  # s in which a blind driver meets one who is slower
TRY_EVERY = 10  # ticks between two tries to send one
GAIN, CLOSING = 0.4, (-3.0, 7.0)  # 1/s, and m/s, with which the gap is made what is wanted
FASTEST = 1.2  # of the speed limit
SLOWER = 0.93  # of the ego's speed, which it comes to while it moves over
PULLS = (-3.0, 2.5)  # m/s2 with which it comes to a speed
KEPT = 0.55  # of its speed that is left after it has braked
CAUTIOUS = 4.5  # m/s2 with which it brakes for its own leader
ROOM, HEADWAY = 3.0, 0.5  # m, and s of its speed, that are free before it
BLOCK_END = 25.0  # m before its edge's end at which it is given up


class CutIn(HoldsTraffic):
    """One vehicle that cuts in; mutable.

    Parameters: `gap` (m), `duration` (s of moving over), `braking` (m/s2 after it), `side` (1 from
    the left, -1 from the right, 0 for either).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._gap = number_of(hazard, "gap", draw)
        self._duration = number_of(hazard, "duration", draw)
        self._braking = number_of(hazard, "braking", draw)
        self._neighbour, self._side = _neighbour(stage, hazard, draw)
        self._other: int | None = None
        self._sent = 0.0  # arc length of the front of one that SUMO has yet to take
        self._centre = self._speed = self._wanted = self._moved = 0.0
        self._line, self._line_along, self._from = np.zeros((2, 2)), np.zeros(2), 0.0

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Find somebody and come to the gap; move over and brake; go on."""
        if self.phase is Phase.COMMITTED:
            self._move(stage)
        elif self._neighbour is None:
            self.end(stage, Phase.VOID, "there is no neighbour lane")
        elif stage.distance_to(self._at + LATE) < 0.0:
            why = "nobody drove beside" if self._other is None else "no fair moment to cut in"
            self.end(stage, Phase.VOID, why)
        elif self._other is not None and not stage.on_road(self._other):
            stage.remove(self._other)
            self._other, self._sent = None, 0.0
        elif self._other is None:
            self._find(ego, stage, self._neighbour)
        elif self._sent:
            self._take(stage, self._other, self._sent)
        else:
            self._prepare(ego, stage, self._neighbour)

    def _find(self, ego: EgoState, stage: HazardWorld, lane: Lane) -> None:
        """Take the one that is nearest to the gap, or send one."""
        states = stage.seen()
        near = {
            abs(stage.distance_to(item.front - EGO_LENGTH) - self._gap): item
            for item in along_route(stage)
            if states[item.number].lane == lane.id
            and stage.kind_of(item.number).kind in (ActorKind.CAR, ActorKind.VAN)
            and NEAREST < stage.distance_to(item.front - EGO_LENGTH) < FARTHEST
            and stage.may_be_placed(item.number, states[item.number])
        }
        if near:
            item = near[min(near)]
            stage.command(item.number)
            stage.keep_lane(item.number)
            self._take(stage, item.number, item.front)
        elif stage.tick % TRY_EVERY == 0 and ego.speed > SLOWEST:
            front = max(stage.progress + SENT_AHEAD, self._at - SENT_BEFORE)
            here = stage.lane_at(front + BLOCK_END)
            if here is not None and here.edge == lane.edge and stage.out_of_sight(front):
                speed = SENT_SPEED * lane.speed_limit
                self._other = stage.send_along(CAR, lane, front, speed)
                self._sent = front
                if self._other is not None:
                    stage.keep_lane(self._other)

    def _take(self, stage: HazardWorld, vehicle: int, front: float) -> None:
        state = stage.state_of(vehicle)
        if state is None:
            return
        self._other, self._sent = vehicle, 0.0
        self._centre = front - 0.5 * stage.kind_of(vehicle).length
        self._speed = state.speed
        x, y, yaw = stage.pose_at(front)
        aside = (state.y - y) * np.cos(yaw) - (state.x - x) * np.sin(yaw)
        self._lay(stage, np.full(200, aside))
        self._advance(stage, 0.0, 0.0)

    def _lay(self, stage: HazardWorld, aside: np.ndarray) -> None:
        """Lay the line that it follows: so far beside the route at each metre from where it is."""
        route, self._from = stage.route, self._centre
        at = self._from + np.arange(len(aside))
        x, y, yaw = (
            np.interp(at, route.along, column)
            for column in (route.points[:, 0], route.points[:, 1], route.headings)
        )
        self._line = np.stack((x - aside * np.sin(yaw), y + aside * np.cos(yaw)), axis=1)
        self._line_along = arc_lengths(self._line)
        self._aside = float(aside[0])

    def _prepare(self, ego: EgoState, stage: HazardWorld, lane: Lane) -> None:
        here = stage.lane_at(self._centre + BLOCK_END)
        if here is None or here.edge != lane.edge:
            self.let_go(stage)
            return
        around = along_route(stage, 140.0)
        gap = stage.distance_to(self._rear(stage))
        early = stage.distance_to(self._at - LATE) > gap + 2.0 * ego.speed
        if not early and self._ready(ego, gap) and self._room(stage, around, 0.0):
            self._advance(stage, 0.0, 0.0)
            self._wanted = min(SLOWER * ego.speed, self._speed + 1.0)
            at = np.arange(200.0)
            share = np.clip(at / max(self._duration * self._wanted, 8.0), 0.0, 1.0)
            aside = 1.0 - share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
            self._lay(stage, self._aside * aside)
            self.phase = Phase.COMMITTED
            return
        closing = min(max(GAIN * (gap - self._gap), CLOSING[0]), CLOSING[1])
        wanted = min(max(ego.speed - closing, SLOWEST), FASTEST * lane.speed_limit)
        if gap > AFAR * ego.speed + 10.0:
            arrived = self._centre > self._at - WAITS_AT
            wanted = 0.0 if arrived else SENT_SPEED * lane.speed_limit
        pull = min(max((wanted - self._speed) / TICK, PULLS[0]), PULLS[1])
        if not self._room(stage, around, self._aside):
            pull = -CAUTIOUS
        self._advance(stage, pull, 0.0)

    def let_go(self, stage: HazardWorld) -> None:
        """Give the vehicle back to the traffic."""
        if self._other is not None:
            stage.hand_back(self._other)
        self._other = None

    def _rear(self, stage: HazardWorld) -> float:
        return self._centre - 0.5 * stage.kind_of(self._other or 0).length

    def _ready(self, ego: EgoState, gap: float) -> bool:
        """Tell whether it may go: at the gap, and with enough left for a surprised driver."""
        closing = max(ego.speed - min(SLOWER * ego.speed, self._speed), 0.0)
        near = abs(gap - self._gap) < TOLERANCE or self._gap < gap < CONTACT * closing
        if min(ego.speed, self._speed) < SLOWEST or not near:
            return False
        unaware = 0.5 * self._duration + REACTION
        left = gap - closing * unaware - 0.5 * max(ego.acceleration, 0.0) * unaware**2
        return left - closing**2 / (2.0 * BRAKING) > LEAST_LEFT

    def _room(self, stage: HazardWorld, around: list[Neighbour], aside: float) -> bool:
        """Tell whether a lane is free from the ego's front to a little before it."""
        ego = stage.progress + 0.5 * EGO_LENGTH
        front = 2.0 * self._centre - self._rear(stage)
        begin = ego if abs(aside) < LANE_HALF else front
        return not any(
            abs(item.offset - aside) < LANE_HALF
            and item.number != self._other
            and item.front > begin
            and item.front - stage.kind_of(item.number).length
            < front + ROOM + HEADWAY * self._speed
            for item in around
        )

    def _move(self, stage: HazardWorld) -> None:
        if self._other is None or not stage.on_road(self._other):
            self.end(stage, Phase.DONE)
            return
        self._moved += TICK
        slowest = KEPT * self._wanted
        pull = min(max((self._wanted - self._speed) / TICK, -1.5), 1.5)
        if self._moved > self._duration:
            pull = -self._braking
        if not self._room(stage, along_route(stage, 140.0), 0.0):
            pull, slowest = -CAUTIOUS, 0.0
        self._advance(stage, pull, slowest)
        if self._moved > self._duration + 0.5 and self._speed <= KEPT * self._wanted:
            self.end(stage, Phase.DONE)

    def _advance(self, stage: HazardWorld, pull: float, slowest: float) -> None:
        if self._other is not None:
            self._speed = max(self._speed + pull * TICK, min(slowest, self._speed))
            self._centre += self._speed * TICK
            along = self._centre - self._from
            stage.place_along(self._other, self._line, self._line_along, along, self._speed)


def _neighbour(
    stage: HazardWorld, hazard: Hazard, draw: random.Random
) -> tuple[Lane | None, float]:
    """Return the lane and the side from which somebody comes."""
    lane, side = stage.lane_at(hazard.at), hazard.parameters.get("side", 0.0)
    beside = {} if lane is None else {1.0: lane.left, -1.0: lane.right}
    known = [(name, key) for key, name in beside.items() if name and side in (0.0, key)]
    if not known:
        return None, 0.0
    name, chosen = draw.choice(known)
    return stage.town.lanes[name], chosen
