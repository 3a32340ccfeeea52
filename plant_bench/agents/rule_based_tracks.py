"""The rule-based planner with a better forecast: what tracks tell in place of straight on."""

import math

from plant_bench.agent import Control, Input, Observation, Reason
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.motion_forecast import MotionForecast
from plant_bench.features.motion import MotionTracker
from plant_bench.world.route import Route


class RuleBasedTracks:
    """Takes all others to go on speeding up, slowing down and turning as they do.

    It is the guard of `plant`, too; alone, it shows what that is worth.

    Args:
        tracks: What remembers who was where, where somebody else does so already.
    """

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})

    def __init__(self, tracks: MotionTracker | None = None) -> None:
        self._forecast = MotionForecast(tracks)
        self._driver = CarefulDriver(self._forecast)

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return self._driver.interval

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._driver.reset(route)
        self._forecast.forget()

    def watch(self, observation: Observation) -> None:
        """Remember who is where, without a decision.

        Raises:
            AgentError: The observation holds no actors.
        """
        self._forecast.watch(observation)

    def act(self, observation: Observation, wish: float = math.inf) -> Control:
        """Drive, with an acceleration of `wish` in m/s2 at the most."""
        self.watch(observation)
        return self._driver.act(observation, wish)

    def explain(self) -> Reason:
        """Return why it drives no faster."""
        return self._driver.explain()
