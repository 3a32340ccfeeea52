"""The planner `sumo`, a baseline: SUMO's own driver model drives the route."""

from plant_bench.agent import Control, Input, Observation
from plant_bench.world.route import Route


class SumoDriver:
    """SUMO's car-following, lane-changing and junction models drive the ego."""

    inputs = frozenset({Input.SIMULATOR})
    interval = 20

    def reset(self, route: Route | None) -> None:
        """Start a new episode; there is no state to clear."""

    def act(self, observation: Observation) -> Control:
        """Return the current control, which is ignored: the simulator drives."""
        return Control(observation.ego.acceleration, observation.ego.steering)
