"""Validates planners: declared inputs, decision interval, actions, reasons and state reset."""

import copy
import math
from collections.abc import Mapping

import numpy as np

from plant_bench.agent import (
    MOST_INTERVAL,
    NO_ACTOR,
    PLAN_STEPS,
    Agent,
    Control,
    Input,
    Observation,
    Plan,
    Ranker,
    Reason,
)
from plant_bench.errors import AgentError
from plant_bench.sensing.inputs import check_inputs
from plant_bench.world.route import Route


def decision_interval(agent: Agent) -> int:
    """Return the number of ticks until a planner's next decision.

    Raises:
        AgentError: Its `interval` is not an integer from 1 to 20.
    """
    interval = getattr(agent, "interval", 1)
    if not isinstance(interval, int) or not 1 <= interval <= MOST_INTERVAL:
        message = f"interval: expected an integer from 1 to {MOST_INTERVAL}, got {interval!r}."
        raise AgentError(message)
    return interval


def reason_of(agent: Agent) -> Reason | None:
    """Return the reason for a planner's last action; None if it gives none.

    Raises:
        AgentError: `explain` returned something other than a `Reason` or None.
    """
    explain = getattr(agent, "explain", None)  # `isinstance` of a protocol takes 10 to 20 us
    if explain is None:
        return None
    reason = explain()
    if reason is not None and not isinstance(reason, Reason):
        message = f"explain: expected a Reason or None, got a {type(reason).__name__}."
        raise AgentError(message)
    return reason


def check_action(action: object) -> Plan | Control:
    """Return the action if it is a finite `Plan` or `Control` of the right shape.

    Raises:
        AgentError: It is not.
    """
    if isinstance(action, Control):
        try:
            control = Control(float(action.acceleration), float(action.steering))
        except (TypeError, ValueError, OverflowError) as error:
            message = f"act: expected a Control of two numbers, got {action}."
            raise AgentError(message) from error
        if not (math.isfinite(control.acceleration) and math.isfinite(control.steering)):
            message = f"act: expected finite numbers, got {action}."
            raise AgentError(message)
        return control
    if isinstance(action, Plan):
        try:
            waypoints = np.asarray(action.waypoints, dtype=float)
        except (TypeError, ValueError) as error:
            message = "act: expected a Plan whose waypoints are numbers."
            raise AgentError(message) from error
        if waypoints.shape != (PLAN_STEPS, 2) or not np.isfinite(waypoints).all():
            message = (
                f"act: expected a Plan of shape ({PLAN_STEPS}, 2), finite waypoints in the ego "
                f"frame, got shape {waypoints.shape}."
            )
            raise AgentError(message)
        return Plan(waypoints)
    message = f"act: expected a Plan or a Control, got a {type(action).__name__}."
    raise AgentError(message)


def same_action(one: Plan | Control, other: Plan | Control) -> bool:
    """Return whether two actions are exactly equal."""
    if isinstance(one, Plan) and isinstance(other, Plan):
        return bool(np.array_equal(one.waypoints, other.waypoints))
    return isinstance(one, Control) and one == other


def check_agent(agent: object, route: Route, observations: list[Observation]) -> None:
    """Check that a planner meets the interface: run it twice on the same observations.

    `reset` must clear its state: the same observations must give the same actions. Actions must be
    valid, and observations must not be modified.

    Args:
        agent: The planner.
        route: A route to reset it with.
        observations: A few ticks of one episode, for instance from a recording.

    Raises:
        AgentError: The planner breaks a rule; the message says which.
    """
    if not isinstance(agent, Agent):
        message = (
            f"{type(agent).__name__} is not a planner: expected the attributes inputs, reset "
            "and act."
        )
        raise AgentError(message)
    check_inputs(agent.inputs, type(agent).__name__)
    decision_interval(agent)
    shown_route = route if Input.ROUTE in agent.inputs else None
    drives: list[list[Plan | Control]] = []
    for _ in range(2):
        agent.reset(shown_route)
        actions = []
        for observation in observations:
            before = copy.deepcopy(observation)
            actions.append(check_action(agent.act(observation)))
            _check_reason(agent, observation)
            if not _equal(before, observation):
                message = f"{type(agent).__name__}.act must not modify its observation."
                raise AgentError(message)
        drives.append(actions)
    if not all(map(same_action, *drives)):
        message = f"{type(agent).__name__} acts differently after reset: reset must clear state."
        raise AgentError(message)
    if isinstance(agent, Ranker):
        _check_ranks(agent, observations)


def _check_reason(agent: Agent, observation: Observation) -> None:
    reason = reason_of(agent)
    if reason is None or reason.actor == NO_ACTOR:
        return
    if observation.actors is None or reason.actor not in observation.actors.ids:
        message = f"explain: expected the id of an actor in sight, got {reason.actor}."
        raise AgentError(message)


def _check_ranks(agent: Ranker, observations: list[Observation]) -> None:
    for observation in observations:
        ranks = np.asarray(agent.rank(observation))
        count = 0 if observation.actors is None else len(observation.actors)
        if ranks.shape != (count,) or not np.isfinite(ranks).all():
            message = f"rank: expected ({count},) finite values, got shape {ranks.shape}."
            raise AgentError(message)


def _equal(one: object, other: object) -> bool:
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_equal(one[name], other[name]) for name in one)
    fields = getattr(type(one), "__dataclass_fields__", None)
    if fields is not None and type(one) is type(other):
        return all(_equal(getattr(one, name), getattr(other, name)) for name in fields)
    return bool(one == other)
