"""The planner `cruise`, a negative control: follows route and lights and ignores all actors."""

from plant_bench.agent import Control, Input, Observation
from plant_bench.agents.idm import idm, light_limit
from plant_bench.controller import follow_route
from plant_bench.errors import AgentError
from plant_bench.features.limits import allowed_speed
from plant_bench.world.route import Route


class Cruise:
    """Drives at the speed limit and stops for red lights."""

    inputs = frozenset({Input.ROUTE, Input.LIGHT})

    def reset(self, route: Route | None) -> None:
        """Start a new episode; there is no state to clear."""

    def act(self, observation: Observation) -> Control:
        """Return the control.

        Raises:
            AgentError: The observation has no route.
        """
        route, ego = observation.route, observation.ego
        if route is None:
            message = "Cruise needs the input 'route'."
            raise AgentError(message)
        acceleration = min(
            idm(ego.speed, allowed_speed(route)), light_limit(ego.speed, observation.light)
        )
        return Control(acceleration, follow_route(ego, route))
