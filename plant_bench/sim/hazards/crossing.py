"""A walker or rider crosses the road (CARLA types 3 and 4), with or without a parked van before it.

The walker starts when the ego's soonest arrival equals its own way to the ego's lane, so that a
driver who goes on meets it; it starts far enough from the lane for a surprised driver to stop.
"""

import math
import random

from plant_bench.sim.hazards.stage import RIDER, VAN, WALKER, Stage
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EGO_WIDTH, EgoState

AHEAD_OF_TIME = 0.3  # s by which the walker is early: the ego meets it, not its trail
BEYOND = 4.0  # m behind the far side of the ego's lane at which the walker is done
FARTHEST_START = 9.0  # m beside the ego's path
VAN_BESIDE = 3.1  # m from the ego's path to the van's middle
VAN_BEFORE = 5.0  # m before the walker


class Crossing:
    """One walker or rider, from the right or the left; mutable.

    Parameters: `speed` (m/s), `side` (-1 from the right, 1 from the left), `rider` (1 for a
    bicycle), `hidden` (1 for a parked van before it).
    """

    def __init__(self, hazard: Hazard, stage: Stage, draw: random.Random) -> None:
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._kind = RIDER if parameters.get("rider", 0.0) else WALKER
        self._speed = parameters.get("speed", 1.4) * draw.uniform(0.9, 1.1)
        self._side = 1.0 if parameters.get("side", -1.0) > 0 else -1.0
        self._hidden = bool(parameters.get("hidden", 0.0))
        limit = stage.speed_limit_at(hazard.at)
        needed = 0.5 + limit / 8.0 + 1.5 / max(limit, 1.0)  # s from first sight, as `Stage.slack`
        clear = 0.5 * EGO_WIDTH + 0.5 * self._kind.length
        self._start = min(clear + self._speed * needed * 1.15, FARTHEST_START)
        self._enters = clear
        self._offset = self._start
        self._actors: list[int] = []

    def step(self, ego: EgoState, stage: Stage) -> None:
        """Put the walker out, let it go in time, and take it away behind the ego."""
        if not self._actors:
            self._appear(stage)
            return
        if self.phase is Phase.ARMED:
            walk = (self._offset - self._enters) / self._speed
            if stage.distance_to(self._at) < 0.0 or not self._fair(ego, stage):
                self._end(stage, Phase.VOID, "the ego was too near to stop")
            elif stage.soonest_arrival(ego, self._at) <= walk + AHEAD_OF_TIME:
                self.phase = Phase.COMMITTED
        elif self._offset > -BEYOND - self._enters:
            self._offset -= self._speed * 0.05
            self._place(stage, self._speed)
        elif stage.distance_to(self._at) < -30.0 or self._offset <= -BEYOND - self._enters:
            self._end(stage, Phase.DONE)

    def _fair(self, ego: EgoState, stage: Stage) -> bool:
        return stage.avoidable(ego, self._at - 0.5 * self._kind.width)

    def _appear(self, stage: Stage) -> None:
        x, y, _ = self._pose(stage)
        if not stage.is_free(x, y, 4.0):
            return
        if self._hidden:
            px, py, heading = stage.pose_at(self._at - VAN_BEFORE)
            aside = self._side * VAN_BESIDE
            vx, vy = px - aside * math.sin(heading), py + aside * math.cos(heading)
            if stage.is_free(vx, vy, 5.0):
                self._actors.append(stage.put(VAN, vx, vy, heading))
        self._actors.insert(0, stage.put(self._kind, *self._pose(stage)))

    def _pose(self, stage: Stage) -> tuple[float, float, float]:
        x, y, heading = stage.pose_at(self._at)
        aside = self._side * self._offset
        yaw = heading - self._side * 0.5 * math.pi
        return x - aside * math.sin(heading), y + aside * math.cos(heading), yaw

    def _place(self, stage: Stage, speed: float) -> None:
        stage.place(self._actors[0], *self._pose(stage), speed)

    def _end(self, stage: Stage, phase: Phase, reason: str = "") -> None:
        for actor in self._actors:
            stage.remove(actor)
        self._actors.clear()
        self.phase, self.reason = phase, reason
