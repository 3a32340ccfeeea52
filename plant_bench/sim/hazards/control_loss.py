"""Control loss (CARLA type 1): grip drops briefly and the steering is perturbed."""

import math
import random

from plant_bench.agent import Control
from plant_bench.sim.hazards.hard_brake import gap_to, leader_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.driver_braking import BRAKING, GRIP, REACTION
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

MIN_SPEED = 3.0  # m/s; no control loss below
# The lateral error of a driver who steers back is 0.02 s/m * pull * speed^2 * duration (measured
# with the expert from 8 to 21 m/s): the pull is limited to an error of 0.8 m.
MAX_PULL = 40.0  # rad m2/s
LATE = 60.0  # m beyond the place within which it may still begin
STOPPING = -1.0  # m/s2 at or below which the ego counts as stopping
FOLLOWING = 1.2  # m/s2 of braking that the leader may require at most
CLEARANCE = 5.0  # m to the leader, and to the next junction when the hazard ends


class ControlLoss:
    """Perturbs the steering in both directions and reduces grip, without an actor; mutable.

    Parameters: `duration` (s), `pull` (amplitude of the steering angle, rad).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        del world
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._duration = hazard.parameters.get("duration", 2.0)
        self._pull = hazard.parameters.get("pull", 0.04) * draw.choice((-1.0, 1.0))
        self._begin = math.inf
        self._waited = False

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Begin at the place if the ego is moving and need not stop; end after the duration."""
        if self.phase is Phase.ARMED and world.progress >= self._at:
            self._begin_if_fair(ego, world)
        elif self.phase is Phase.COMMITTED and world.time - self._begin > self._duration:
            self.phase = Phase.DONE

    def _begin_if_fair(self, ego: EgoState, world: HazardWorld) -> None:
        slow, stops = ego.speed < MIN_SPEED, self._must_stop(ego, world)
        self._waited |= stops and not slow
        if world.progress > self._at + LATE or self._leaves_lane(ego, world):
            self.phase = Phase.VOID
            self.reason = "the ego had to stop soon" if self._waited else "the ego was too slow"
        elif not slow and not stops:
            self.phase, self._begin = Phase.COMMITTED, world.time
            most = MAX_PULL / (ego.speed**2 * self._duration)
            self._pull = math.copysign(min(abs(self._pull), most), self._pull)

    def _leaves_lane(self, ego: EgoState, world: HazardWorld) -> bool:
        """Tell whether the ego enters a junction or changes lanes before the hazard ends."""
        reach = world.progress + ego.speed * self._duration + CLEARANCE
        starts = [item.entry for item in world.route.passages]
        starts += [item.start for item in world.route.lane_changes]
        return any(self._at < start < reach for start in starts)

    def _must_stop(self, ego: EgoState, world: HazardWorld) -> bool:
        """Tell whether a light or the leader may require more braking than the grip allows."""
        reach = REACTION * ego.speed + ego.speed**2 / (2.0 * GRIP * BRAKING)
        light = any(0.0 < world.distance_to(x) < reach for x in world.route.signal_entries)
        return light or ego.acceleration < STOPPING or _must_brake_for_leader(ego, world)

    def disturb(self, control: Control, world: HazardWorld) -> Control:
        """Return the perturbed control."""
        if self.phase is not Phase.COMMITTED:
            return control
        swing = math.sin(2.0 * math.pi * (world.time - self._begin) / self._duration)
        return Control(GRIP * control.acceleration, control.steering + self._pull * swing)


def _must_brake_for_leader(ego: EgoState, world: HazardWorld) -> bool:
    """Tell whether the ego must brake noticeably for the leader."""
    leader = leader_of(world)
    if leader is None or leader.speed >= ego.speed:
        return False
    distance = gap_to(world, leader) - CLEARANCE
    return distance <= 0.0 or (ego.speed**2 - leader.speed**2) / (2.0 * distance) > FOLLOWING
