"""The planner `expert`: the careful driver with a privileged forecast (PlanT, section 4)."""

from plant_bench.agent import Control, Input, Observation, Reason
from plant_bench.agents.careful.driver import CarefulDriver
from plant_bench.agents.careful.forecast import along_true_lanes
from plant_bench.world.route import Route


class Expert:
    """Rule-based driver that knows each vehicle's true lanes, acceleration and right of way."""

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT, Input.PRIVILEGED})

    def __init__(self) -> None:
        self._driver = CarefulDriver(along_true_lanes)

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
