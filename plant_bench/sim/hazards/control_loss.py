"""Control loss (CARLA type 1): for a moment the road is slippery and the wheels pull aside."""

import math
import random

from plant_bench.agent import Control
from plant_bench.sim.hazards.hard_brake import gap_to, leader_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.driver_braking import BRAKING, GRIP, REACTION
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

LEAST_SPEED = 3.0  # m/s, below which nothing slips
# The lateral error of a driver who steers back is 0.02 s/m * pull * speed^2 * duration (measured
# with the expert from 8 to 21 m/s): the pull is kept to what leaves 0.8 m.
HARDEST = 40.0  # rad m2/s
LATE = 60.0  # m beyond the place within which it may begin, if a stop is near there
BRAKES = -1.0  # m/s2 from which on the ego is stopping
AMPLE = 1.2  # m/s2 that are enough to stay behind who drives ahead
KEEPS = 5.0  # m to who drives ahead, and to the next junction when it is over


class ControlLoss:
    """Steering is pulled from side to side, and grip is reduced; no actor takes part; mutable.

    Parameters: `duration` (s), `pull` (rad of steering at the most).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        del stage
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._duration = hazard.parameters.get("duration", 2.0)
        self._pull = hazard.parameters.get("pull", 0.04) * draw.choice((-1.0, 1.0))
        self._begin = math.inf
        self._waited = False

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Begin at the place, if the ego is moving and need not stop; end after the duration."""
        if self.phase is Phase.ARMED and stage.progress >= self._at:
            self._begin_if_fair(ego, stage)
        elif self.phase is Phase.COMMITTED and stage.time - self._begin > self._duration:
            self.phase = Phase.DONE

    def _begin_if_fair(self, ego: EgoState, stage: HazardWorld) -> None:
        slow, stops = ego.speed < LEAST_SPEED, self._must_stop(ego, stage)
        self._waited |= stops and not slow
        if stage.progress > self._at + LATE or self._leaves_lane(ego, stage):
            self.phase = Phase.VOID
            self.reason = (
                "a stop was near" if self._waited else "the ego was slower than anything slips"
            )
        elif not slow and not stops:
            self.phase, self._begin = Phase.COMMITTED, stage.time
            most = HARDEST / (ego.speed**2 * self._duration)
            self._pull = math.copysign(min(abs(self._pull), most), self._pull)

    def _leaves_lane(self, ego: EgoState, stage: HazardWorld) -> bool:
        """Tell whether the ego enters a junction or changes lanes too soon."""
        reach = stage.progress + ego.speed * self._duration + KEEPS
        starts = [item.entry for item in stage.route.passages]
        starts += [item.start for item in stage.route.lane_changes]
        return any(self._at < start < reach for start in starts)

    def _must_stop(self, ego: EgoState, stage: HazardWorld) -> bool:
        """Tell whether a light, or who drives ahead, may ask for more than the grip allows."""
        reach = REACTION * ego.speed + ego.speed**2 / (2.0 * GRIP * BRAKING)
        light = any(0.0 < stage.distance_to(x) < reach for x in stage.route.signal_entries)
        return light or ego.acceleration < BRAKES or _presses(ego, stage)

    def disturb(self, control: Control, stage: HazardWorld) -> Control:
        """Return the control that reaches the road."""
        if self.phase is not Phase.COMMITTED:
            return control
        swing = math.sin(2.0 * math.pi * (stage.time - self._begin) / self._duration)
        return Control(GRIP * control.acceleration, control.steering + self._pull * swing)


def _presses(ego: EgoState, stage: HazardWorld) -> bool:
    """Tell whether the ego comes too near to who drives ahead."""
    leader = leader_of(stage)
    if leader is None or leader.speed >= ego.speed:
        return False
    room = gap_to(stage, leader) - KEEPS
    return room <= 0.0 or (ego.speed**2 - leader.speed**2) / (2.0 * room) > AMPLE
