"""The planner `idm`, a baseline: follows its leader by the IDM and stops at red lights."""

from plant_bench.agent import Control, Input, Observation
from plant_bench.agents.careful.driver import HALF, INTERVAL
from plant_bench.agents.careful.leader import corridor
from plant_bench.agents.idm import idm, light_limit
from plant_bench.controller import follow_route
from plant_bench.errors import AgentError
from plant_bench.features.limits import allowed_speed
from plant_bench.world.route import Route


class IdmFollower:
    """Keeps its distance from the vehicle ahead; never yields to crossing traffic."""

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})
    interval = INTERVAL

    def reset(self, route: Route | None) -> None:
        """Start a new episode; there is no state to clear."""

    def act(self, observation: Observation) -> Control:
        """Return the control.

        Raises:
            AgentError: An input is missing.
        """
        route, actors, ego = observation.route, observation.actors, observation.ego
        if route is None or actors is None:
            message = "The IDM follower needs the inputs 'objects' and 'route'."
            raise AgentError(message)
        leader = corridor(route, actors, route.past, ego.speed).leader()
        target = allowed_speed(route)
        acceleration = min(
            idm(ego.speed, target, leader.distance - HALF, leader.speed),
            light_limit(ego.speed, observation.light),
        )
        return Control(acceleration, follow_route(ego, route))
