"""Detects running a red light: the ego's rear crosses the stop line at red (CARLA LB 1.0)."""

import numpy as np
from jaxtyping import UInt8

from plant_bench.world.route import Route
from plant_bench.world.scene import EGO_LENGTH, Light

# The segment behind the ego's centre that must cross: RunningRedLightTest of scenario_runner 1.0.
REAR_NEAR = 0.8 * 0.5 * EGO_LENGTH  # m: 0.8 of the half-length (RunningRedLightTest)
REAR_FAR = 0.5 * EGO_LENGTH + 1.0  # m: the half-length and a metre (RunningRedLightTest)
STOP_LINE_REACH = 5.0  # m to either side of the route: own choice, own and adjacent lanes


class RedLights:
    """Watches the stop lines of one route; mutable.

    Args:
        route: The route driven.
    """

    def __init__(self, route: Route) -> None:
        self._lines = [passage.entry for passage in route.signal_passages]
        self._names = [(item.signal, item.signal_index) for item in route.signal_passages]
        self._next = 0
        self._last_run: tuple[str | None, int] | None = None

    def run(
        self, before: float, progress: float, offset: float, lights: UInt8[np.ndarray, " signals"]
    ) -> bool:
        """Return whether the rear crosses the next stop line at red in this tick.

        The rear segment extends from its far end at the last tick to its near end now, so that no
        line is skipped at any speed. Yellow is allowed, and so is stopping on the line.

        Args:
            before: Arc length of the ego's centre at the last tick.
            progress: Arc length of the ego's centre now.
            offset: The ego's lateral distance from the route.
            lights: States of the route's lights.
        """
        if self._next == len(self._lines) or progress - REAR_NEAR < self._lines[self._next]:
            return False
        at = self._next
        if progress - REAR_FAR > self._lines[at]:
            self._next += 1
        if progress <= before or abs(offset) > STOP_LINE_REACH or lights[at] != Light.RED:
            return False
        if self._names[at] == self._last_run:
            return False
        self._last_run = self._names[at]
        return True
