"""The planner `rule-based-tracks`: `rule-based`, but forecasting accelerations and turns."""

import math

from plant_bench.agent import Control, Input, Observation, Reason
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.motion_forecast import MotionForecast
from plant_bench.features.motion import MotionTracker
from plant_bench.world.route import Route


class RuleBasedTracks:
    """Predicts that all actors keep their accelerations and turn rates.

    Also the safety layer of `plant`; driving alone, it shows what that layer contributes.

    Args:
        tracker: A motion tracker to share; a new one by default.
    """

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})

    def __init__(self, tracker: MotionTracker | None = None) -> None:
        self._forecast = MotionForecast(tracker)
        self._driver = CarefulDriver(self._forecast)

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return self._driver.interval

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._driver.reset(route)
        self._forecast.reset()

    def update(self, observation: Observation) -> None:
        """Update the motion tracker without a decision.

        Raises:
            AgentError: The observation has no actors.
        """
        self._forecast.update(observation)

    def act(self, observation: Observation, max_acceleration: float = math.inf) -> Control:
        """Return the control, with at most `max_acceleration`, m/s2."""
        self.update(observation)
        return self._driver.act(observation, max_acceleration)

    def explain(self) -> Reason:
        """Return what limits its speed."""
        return self._driver.explain()
