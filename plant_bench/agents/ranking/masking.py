"""Leave-one-out relevance of vehicles for planners without `rank` (PlanT, section 4.3: masking).

Each vehicle in turn is removed from the observation; its relevance is the change of the plan.
"""

import copy
import math

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PLAN_INTERVAL, PLAN_STEPS, Agent, Control, Input, Observation, Plan
from plant_bench.agent_check import check_action
from plant_bench.agents.ranking.rankers import actors_of, distances
from plant_bench.errors import AgentError
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, WHEELBASE, ActorKind, EgoState


class Masking:
    """Ranks vehicles by the L1 change of a planner's waypoints without them.

    The planner itself sees the complete scene. Copies of it (`copy.deepcopy`) see the scenes
    without a vehicle, so planners with internal state work, too.

    Args:
        agent: The planner; its actions are never executed.

    Raises:
        AgentError: It has no input 'objects'.
    """

    def __init__(self, agent: Agent) -> None:
        if Input.OBJECTS not in agent.inputs:
            message = (
                f"{type(agent).__name__} has no input 'objects': no vehicle can influence it, so "
                "there is nothing to rank."
            )
            raise AgentError(message)
        self._agent = agent
        self.inputs = agent.inputs

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._agent.reset(route)

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the change of the plan without each vehicle, metres.

        Vehicles that change nothing, and pedestrians, rank below 0, nearer ones higher.

        Raises:
            AgentError: The planner cannot be copied, or its action is not valid.
        """
        actors = actors_of(observation)
        ranks = -distances(observation.ego, actors)
        before = self._copy()
        whole = _waypoints(self._agent, observation)
        for place in np.flatnonzero(actors.kinds != ActorKind.PEDESTRIAN).tolist():
            left = observation.showing(np.arange(len(actors)) != place)
            change = float(np.abs(_waypoints(copy.deepcopy(before), left) - whole).sum())
            if change > 0.0:
                ranks[place] = change
        return ranks

    def _copy(self) -> Agent:
        try:
            return copy.deepcopy(self._agent)
        except Exception as error:  # whatever a planner holds that cannot be copied
            message = (
                f"{type(self._agent).__name__} cannot be copied ({type(error).__name__}: {error}): "
                "masking runs copies of it. Give it a __deepcopy__ that shares immutable parts."
            )
            raise AgentError(message) from error


def expected_waypoints(control: Control, ego: EgoState) -> Float[np.ndarray, "waypoints 2"]:
    """Return the waypoints of a constant control (kinematic bicycle), in the ego frame, metres."""
    speed, yaw, x, y = ego.speed, 0.0, 0.0, 0.0
    turn = math.tan(control.steering) / WHEELBASE
    points = []
    every = round(PLAN_INTERVAL / TICK)
    for step in range(1, PLAN_STEPS * every + 1):
        speed = max(speed + control.acceleration * TICK, 0.0)
        yaw += speed * turn * TICK
        x, y = x + speed * math.cos(yaw) * TICK, y + speed * math.sin(yaw) * TICK
        if step % every == 0:
            points.append((x, y))
    return np.array(points)


def _waypoints(agent: Agent, observation: Observation) -> Float[np.ndarray, "waypoints 2"]:
    action = check_action(agent.act(observation))
    return (
        action.waypoints
        if isinstance(action, Plan)
        else expected_waypoints(action, observation.ego)
    )
