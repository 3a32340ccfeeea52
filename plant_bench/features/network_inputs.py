"""Converts an observation into PlanT's network inputs, for training and for driving."""

import math
from dataclasses import dataclass

from plant_bench.agent import Observation, RouteAhead
from plant_bench.errors import AgentError
from plant_bench.features.limits import allowed_speed
from plant_bench.features.motion import Rates
from plant_bench.features.tokens import STOPS, Tokens, TokenSpec, tokens_of
from plant_bench.world.scene import EgoState

TARGET_AHEAD = 20  # m along the route to the decoder's target point


@dataclass(frozen=True, eq=False, slots=True)
class SceneInput:
    """The network inputs of one scene.

    Attributes:
        tokens: The object tokens.
        red: 1 if the next light within `plant_bench.agent.LIGHT_RANGE` is red or yellow, else 0.
        target: The route point `TARGET_AHEAD` metres ahead, in the ego frame, metres; the route's
            last point near its end.
        speed: The ego's speed, m/s. Not an input in the PlanT paper.
        limit: `allowed_speed`, m/s. Not an input in the PlanT paper.
    """

    tokens: Tokens
    red: float
    target: tuple[float, float]
    speed: float
    limit: float


def scene_input(
    observation: Observation, spec: TokenSpec, rates: Rates | None = None
) -> SceneInput:
    """Return the network inputs of an observation.

    Args:
        observation: The observation.
        spec: Which objects become tokens, and their attributes.
        rates: The rates of the observation's actors, if `spec.motion`.

    Raises:
        AgentError: The observation lacks objects or route.
    """
    ego, actors, route, light = (
        observation.ego,
        observation.actors,
        observation.route,
        observation.light,
    )
    if actors is None or route is None:
        message = "A learned planner needs the inputs 'objects' and 'route'."
        raise AgentError(message)
    return SceneInput(
        tokens_of(ego, actors, route, spec, light, rates),
        float(light is not None and light.state in STOPS),
        _target(ego, route),
        float(ego.speed),
        allowed_speed(route),
    )


def _target(ego: EgoState, route: RouteAhead) -> tuple[float, float]:
    x, y = route.points[min(TARGET_AHEAD, len(route.points) - 1)].tolist()
    cos, sin, dx, dy = math.cos(ego.yaw), math.sin(ego.yaw), x - ego.x, y - ego.y
    return cos * dx + sin * dy, cos * dy - sin * dx
