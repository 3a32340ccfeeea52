"""Control loss (CARLA type 1): for a moment the road is slippery and the wheels pull aside."""

import math
import random

from plant_bench.agent import Control
from plant_bench.sim.hazards.stage import Stage
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

GRIP = 0.6  # share of acceleration and braking that is left
LEAST_SPEED = 3.0  # m/s, below which nothing slips
# The lateral error of a driver who steers back is 0.02 s/m * pull * speed^2 * duration (measured
# with the expert from 8 to 21 m/s): the pull is kept to what leaves 0.8 m.
HARDEST = 40.0  # rad m2/s


class ControlLoss:
    """Steering is pulled from side to side, and grip is reduced; no actor takes part; mutable.

    Parameters: `duration` (s), `pull` (rad of steering at the most).
    """

    def __init__(self, hazard: Hazard, stage: Stage, draw: random.Random) -> None:
        del stage
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._duration = hazard.parameters.get("duration", 2.0)
        self._pull = hazard.parameters.get("pull", 0.04) * draw.choice((-1.0, 1.0))
        self._begin = math.inf

    def step(self, ego: EgoState, stage: Stage) -> None:
        """Begin at the place, if the ego is moving; end after the duration."""
        if self.phase is Phase.ARMED and stage.progress >= self._at:
            if ego.speed < LEAST_SPEED:
                self.phase, self.reason = Phase.VOID, "the ego was slower than anything slips"
                return
            self.phase, self._begin = Phase.COMMITTED, stage.time
            most = HARDEST / (ego.speed**2 * self._duration)
            self._pull = math.copysign(min(abs(self._pull), most), self._pull)
        elif self.phase is Phase.COMMITTED and stage.time - self._begin > self._duration:
            self.phase = Phase.DONE

    def disturb(self, control: Control, stage: Stage) -> Control:
        """Return the control that reaches the road."""
        if self.phase is not Phase.COMMITTED:
            return control
        swing = math.sin(2.0 * math.pi * (stage.time - self._begin) / self._duration)
        return Control(GRIP * control.acceleration, control.steering + self._pull * swing)
