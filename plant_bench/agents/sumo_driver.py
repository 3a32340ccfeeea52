"""A reference line: SUMO's own driver on the same route, without any forecast of ours."""

from plant_bench.agent import Control, Input, Observation
from plant_bench.world.route import Route


class SumoDriver:
    """Is driven by SUMO's car following, lane changing and junction rules."""

    inputs = frozenset({Input.SIMULATOR})
    interval = 20

    def reset(self, route: Route | None) -> None:
        """Start a new episode; there is nothing to do."""

    def act(self, observation: Observation) -> Control:
        """Answer with nothing: the simulator drives."""
        return Control(observation.ego.acceleration, observation.ego.steering)
