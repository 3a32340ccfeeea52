"""Queries a planner: when it is due, with its observation, and with its action checked.

`PlannerSession` is used by the episode loop, by DAgger, by explanations (planners queried without
executing their actions), and by replays.
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
    """What a planner answers to one scene.

    Attributes:
        tick: Of the scene.
        action: Its plan or control.
        control: The control that carries it out.
        reason: Why; None where it does not explain itself.
        ranking: The ids of the actors that matter to it, the most relevant first; None where it was
            not asked for, or nobody can tell.
    """

    tick: int
    action: Plan | Control
    control: Control
    reason: Reason | None
    ranking: tuple[int, ...] | None = None


class PlannerSession:
    """One planner through one episode; mutable. Whatever the planner raises is an `AgentError`.

    Attributes:
        agent: The planner.
        privileged: Whether it must be given what only the simulator knows.

    Args:
        agent: The planner; see `start`.
        route: The route being driven.
        seed: The scenario's, for what the planner is shown.
        name: Put before the names of its methods in messages, as in "the driver's ".
    """

    def __init__(self, agent: Agent, route: Route, seed: int, name: str = "") -> None:
        self.agent = agent
        self.privileged = Input.PRIVILEGED in agent.inputs
        self._sensors = Sensors(route, seed, agent.inputs)
        self._route, self._name, self._due = route, name, 0

    def start(self) -> None:
        """Reset the planner: it is told the route, if it asks for it.

        Raises:
            AgentError: It cannot be reset.
        """
        plan = self._route.plan if Input.ROUTE in self._sensors.inputs else None
        call_planner(f"{self._name}reset", self.agent.reset, plan)
        self._due = 0

    def due(self, tick: int) -> bool:
        """Tell whether the planner decides at this tick."""
        return tick >= self._due

    def observe(
        self, scene: Scene, progress: float, offset: float, facts: Privileged | None
    ) -> Observation:
        """Return what the planner is shown of a scene; as `Sensors.observe`."""
        return self._sensors.observe(scene, progress, offset, facts)

    def decide(self, scene: Scene, seen: Observation) -> Decision:
        """Return what the planner answers; to be called when it is due.

        Args:
            scene: What there is.
            seen: What the planner is shown of it, see `observe`.

        Raises:
            AgentError: The planner fails.
        """
        answer = call_planner(f"{self._name}act", self.agent.act, seen)
        reason = self._reason()
        action = check_action(answer)
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
    """Tell whether a decision is what was recorded at its tick, but for rounding of the network."""
    action = decision.action
    if isinstance(action, Plan) and isinstance(recorded, Plan):
        return bool(np.allclose(action.waypoints, recorded.waypoints, rtol=0.0, atol=1e-4))
    if isinstance(action, Control) and isinstance(recorded, Control):
        pair = (action.acceleration, action.steering), (recorded.acceleration, recorded.steering)
        return bool(np.allclose(*pair, rtol=0.0, atol=1e-6))
    return False


def call_planner(what: str, method: Callable[..., Any], *given: object) -> Any:
    """Return what a planner's method answers; what it raises ends its own episode, no more.

    Raises:
        AgentError: It raised something.
    """
    try:
        return method(*given)
    except (Exception, SystemExit) as error:
        message = f"{what} raised {type(error).__name__}: {error}"
        raise AgentError(message) from error
