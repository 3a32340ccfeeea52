"""Queries a planner through one episode and checks its actions.

`PlannerSession` is used by the episode loop, by DAgger, by replays, and by postmortems in shadow
mode (planners queried without executing their actions).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plant_bench.agent import (
    Agent,
    Control,
    Input,
    Observation,
    Plan,
    Privileged,
    Reason,
)
from plant_bench.agent_check import check_action, decision_interval, reason_of
from plant_bench.controller import control_of
from plant_bench.errors import AgentError
from plant_bench.sensing.observe import Sensors
from plant_bench.world.route import Route
from plant_bench.world.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Decision:
    """A planner's decision in one scene.

    Attributes:
        tick: Tick of the scene.
        action: The planner's plan or control.
        control: The control that executes the action.
        reason: The planner's reason; None if it gives none.
        ranking: Ids of the relevant actors, the most relevant first; None if not queried or not
            available.
    """

    tick: int
    action: Plan | Control
    control: Control
    reason: Reason | None
    ranking: tuple[int, ...] | None = None


class PlannerSession:
    """Queries one planner through one episode; mutable. Its exceptions become `AgentError`s.

    Attributes:
        agent: The planner.
        privileged: Whether the planner has privileged inputs.

    Args:
        agent: The planner; see `start`.
        route: The route being driven.
        seed: The scenario's seed, for sensor noise.
        name: Prefix of method names in error messages, such as "the driver's ".
    """

    def __init__(self, agent: Agent, route: Route, seed: int, name: str = "") -> None:
        self.agent = agent
        self.privileged = Input.PRIVILEGED in agent.inputs
        self._sensors = Sensors(route, seed, agent.inputs)
        self._route, self._name, self._due = route, name, 0

    def start(self) -> None:
        """Reset the planner; its input is the route if it requests that.

        Raises:
            AgentError: The planner's `reset` fails.
        """
        plan = self._route.plan if Input.ROUTE in self._sensors.inputs else None
        call_planner(f"{self._name}reset", self.agent.reset, plan)
        self._due = 0

    def due(self, tick: int) -> bool:
        """Return whether the planner decides at this tick."""
        return tick >= self._due

    def observe(
        self, scene: Scene, progress: float, offset: float, facts: Privileged | None
    ) -> Observation:
        """Return the planner's observation of a scene; see `Sensors.observe`."""
        return self._sensors.observe(scene, progress, offset, facts)

    def decide(self, scene: Scene, observation: Observation) -> Decision:
        """Return the planner's decision; to be called when it is due.

        Args:
            scene: The scene.
            observation: The planner's observation of it, from `observe`.

        Raises:
            AgentError: The planner fails.
        """
        returned = call_planner(f"{self._name}act", self.agent.act, observation)
        reason = self._reason()
        action = check_action(returned)
        self._due = scene.tick + decision_interval(self.agent)
        return Decision(scene.tick, action, control_of(action, scene.ego), reason)

    def _reason(self) -> Reason | None:
        try:
            return reason_of(self.agent)
        except AgentError:
            raise
        except (Exception, SystemExit) as error:
            message = f"{self._name}explain raised {type(error).__name__}: {error}"
            raise AgentError(message) from error


def same_action(decision: Decision, recorded: Plan | Control | None) -> bool:
    """Return whether a decision equals the recorded action, up to rounding by the network."""
    action = decision.action
    if isinstance(action, Plan) and isinstance(recorded, Plan):
        return bool(np.allclose(action.waypoints, recorded.waypoints, rtol=0.0, atol=1e-4))
    if isinstance(action, Control) and isinstance(recorded, Control):
        pair = (action.acceleration, action.steering), (recorded.acceleration, recorded.steering)
        return bool(np.allclose(*pair, rtol=0.0, atol=1e-6))
    return False


def call_planner(name: str, method: Callable[..., Any], *arguments: object) -> Any:
    """Call a planner's method; its exceptions fail the episode, not the run.

    Raises:
        AgentError: The method raised an exception.
    """
    try:
        return method(*arguments)
    except (Exception, SystemExit) as error:
        message = f"{name} raised {type(error).__name__}: {error}"
        raise AgentError(message) from error
