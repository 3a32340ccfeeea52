"""The leader brakes hard to a stop, stands for a moment and goes on.

A vehicle that drives ahead of the ego is taken, or one is sent out of sight and lets the ego come
near. It keeps a sane distance while it is armed, and brakes no harder than a surprised driver who
follows at that distance can answer.
"""

import math
import random
from typing import NamedTuple

import numpy as np

from plant_bench.sim.hazards.behaviour import HoldsTraffic, number_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.driver_braking import BRAKING, REACTION, SPARE
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_LENGTH, ActorKind, EgoState

GENTLEST = 6.0  # m/s2: gentler braking is no hazard
SLOWEST = 4.0  # m/s of the leader and of the ego, below which braking is no hazard
SENT_AHEAD = 90.0  # m before the ego at which a leader is sent when there is none
SENT_SPEED = 0.35  # of the speed limit
LATE = 40.0  # m before and beyond the hazard's place where it may happen too
TRY_EVERY = 10  # ticks between two tries to send one
LANE_HALF = 1.2  # m from the route within which a front is on the ego's lane
BRISK = 0.5  # of the speed limit: who is slower brakes only when it is getting late
GAIN = 0.25  # 1/s: how fast a gap is corrected
WAITING, ALONG, FASTEST = 0.35, 0.75, 1.2  # of the speed limit: of who waits for the ego from afar,
# of who drives before it, and of who must get away from it
AFAR = 1.5  # s of headway more than wanted that are far
EARLY = 0.3  # s before the leader goes on at which a blind driver would be there at the latest


class Neighbour(NamedTuple):
    """A vehicle that drives the route's way.

    Attributes:
        number: The vehicle's.
        front: Arc length of its front on the route, metres.
        offset: Of its front from the route, positive to the left, metres.
        speed: m/s.
    """

    number: int
    front: float
    offset: float
    speed: float


class HardBrake(HoldsTraffic):
    """One leader that brakes; mutable.

    Parameters: `braking` (m/s2), `headway` (s, which it comes to before), `wait` (s it stands).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        del stage
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._braking = number_of(hazard, "braking", draw)
        self._headway = parameters.get("headway", draw.uniform(1.4, 1.7))
        self._wait = number_of(hazard, "wait", draw)
        self._leader: int | None = None
        self._stood: float | None = None

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Find a leader and come to the wanted gap; brake; go on."""
        if self.phase is Phase.COMMITTED:
            self._stand(stage)
        elif stage.distance_to(self._at + LATE) < 0.0:
            why = "nobody drove ahead" if self._leader is None else "no fair moment to brake"
            self.end(stage, Phase.VOID, why)
        else:
            self._prepare(ego, stage)

    def _prepare(self, ego: EgoState, stage: HazardWorld) -> None:
        leader = leader_of(stage)
        if leader is None:
            if self._leader is None or not stage.on_road(self._leader):
                self._send(stage)
            elif stage.tick % TRY_EVERY == 0:
                stage.drive(self._leader, SENT_SPEED * stage.speed_limit_at(self._at))
            return
        if leader.number != self._leader:
            if self._leader is not None:
                stage.hand_back(self._leader)
            self._leader = leader.number
            stage.command(leader.number)
        gap = gap_to(stage, leader)
        braking = self._fair_braking(ego, leader, gap)
        if braking is None or gap > self._farthest(ego, leader, braking):
            wanted = 2.0 + self._headway * ego.speed
            limit = stage.speed_limit_at(leader.front)
            stage.drive(leader.number, speed_for_gap(ego, gap, wanted, limit))
        elif self._is_place(stage, leader, braking):
            stage.brake_hard(leader.number, braking)
            self.phase = Phase.COMMITTED

    def _is_place(self, stage: HazardWorld, leader: Neighbour, braking: float) -> bool:
        """Tell whether this is where to brake; rather not for one who is slow anyway."""
        stops = leader.front + leader.speed**2 / (2.0 * braking)
        brisk = leader.speed > BRISK * stage.speed_limit_at(leader.front)
        begin = self._at - LATE if brisk else self._at
        here = begin <= stops <= self._at + LATE + CAR.length
        return here and stage.lane_at(stops) is not None

    def _send(self, stage: HazardWorld) -> None:
        front = stage.progress + SENT_AHEAD
        lane = stage.lane_at(front)
        if lane is not None and stage.tick % TRY_EVERY == 0 and stage.out_of_sight(front):
            self._leader = stage.send_along(CAR, lane, front, SENT_SPEED * lane.speed_limit)

    def _fair_braking(self, ego: EgoState, leader: Neighbour, gap: float) -> float | None:
        """Return how hard the leader may brake, None if no hazard would be fair or one at all."""
        if min(ego.speed, leader.speed) < SLOWEST:
            return None
        stop = REACTION * ego.speed + ego.speed**2 / (2.0 * BRAKING)
        room = stop + SPARE - gap  # m that the leader must need to stop, at least
        braking = min(self._braking, leader.speed**2 / (2.0 * room) if room > 0.0 else 99.0)
        return braking if braking >= GENTLEST else None

    def _farthest(self, ego: EgoState, leader: Neighbour, braking: float) -> float:
        """Return the gap from which a driver who goes on arrives while the leader stands."""
        stands = leader.speed / braking + self._wait - EARLY
        return ego.speed * stands - leader.speed**2 / (2.0 * braking)

    def _stand(self, stage: HazardWorld) -> None:
        state = stage.state_of(self._leader) if self._leader is not None else None
        if state is None:
            self.end(stage, Phase.DONE)
        elif state.speed < 0.1 and self._stood is None:
            self._stood = stage.time
        elif self._stood is not None and stage.time - self._stood > self._wait:
            self.end(stage, Phase.DONE)

    def let_go(self, stage: HazardWorld) -> None:
        """Give the leader back to the traffic."""
        if self._leader is not None:
            stage.hand_back(self._leader)


def leader_of(stage: HazardWorld) -> Neighbour | None:
    """Return the car or van ahead of the ego on its lane and in its sight."""
    front = stage.progress + 0.5 * EGO_LENGTH
    for item in along_route(stage):
        kind = stage.kind_of(item.number)
        drives = kind.kind in (ActorKind.CAR, ActorKind.VAN)
        if drives and abs(item.offset) < LANE_HALF and item.front - 0.5 * kind.length > front:
            return item
    return None


def gap_to(stage: HazardWorld, other: Neighbour) -> float:
    """Return the metres from the ego's front to another's rear along the route."""
    return stage.distance_to(other.front - stage.kind_of(other.number).length)


def speed_for_gap(ego: EgoState, gap: float, wanted: float, limit: float) -> float:
    """Return the speed by which one who drives ahead comes to a wanted gap."""
    slowest = WAITING if gap > wanted + AFAR * ego.speed else ALONG
    speed = ego.speed + GAIN * (wanted - gap)
    return min(max(speed, slowest * limit), FASTEST * limit)


def along_route(stage: HazardWorld, ahead: float = 80.0) -> list[Neighbour]:
    """Return the vehicles in sight that drive the route's way beside or ahead of the ego.

    They lie from 30 m behind the ego to `ahead` metres before it, the rearmost first.
    """
    route, found = stage.route, []
    first, last = np.searchsorted(route.along, (stage.progress - 30.0, stage.progress + ahead))
    points, headings = route.points[first : last + 1], route.headings[first : last + 1]
    seen = stage.seen()
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
        found.append(Neighbour(number, along, y * cos - x * sin, state.speed))
    return sorted(found, key=lambda item: item.front)
