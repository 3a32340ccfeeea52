"""The planner `rule-based`: the expert's algorithm without privileged inputs (PlanT, section 4)."""

from plant_bench.agent import Control, Input, Observation, Reason
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.forecast import straight_on
from plant_bench.world.route import Route


class RuleBased:
    """Predicts constant speed and heading for all actors."""

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})

    def __init__(self) -> None:
        self._driver = CarefulDriver(straight_on)

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return self._driver.interval

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._driver.reset(route)

    def act(self, observation: Observation) -> Control:
        """Return the control."""
        return self._driver.act(observation)

    def explain(self) -> Reason:
        """Return what limits its speed."""
        return self._driver.explain()
