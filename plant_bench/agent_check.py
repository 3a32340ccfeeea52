"""Checks of what planners declare and answer: the other side of the contract in `agent.py`."""

import copy
import math
from collections.abc import Mapping

import numpy as np

from plant_bench.agent import (
    MOST_INTERVAL,
    NOBODY,
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
    """Return after how many ticks a planner wants to decide again.

    Raises:
        AgentError: Its `interval` is no whole number of 1 to 20.
    """
    interval = getattr(agent, "interval", 1)
    if not isinstance(interval, int) or not 1 <= interval <= MOST_INTERVAL:
        message = f"interval {interval!r}: a whole number from 1 to {MOST_INTERVAL} is wanted."
        raise AgentError(message)
    return interval


def reason_of(agent: Agent) -> Reason | None:
    """Return why a planner acted as it just did; None if it does not explain itself.

    Raises:
        AgentError: It gives something that is no `Reason`.
    """
    explain = getattr(agent, "explain", None)  # `isinstance` of a protocol takes 10 to 20 us
    if explain is None:
        return None
    reason = explain()
    if reason is not None and not isinstance(reason, Reason):
        message = f"explain returned a {type(reason).__name__}: a Reason or None is wanted."
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
            message = f"act returned {action}: two numbers are wanted."
            raise AgentError(message) from error
        if not (math.isfinite(control.acceleration) and math.isfinite(control.steering)):
            message = f"act returned {action}: finite numbers are wanted."
            raise AgentError(message)
        return control
    if isinstance(action, Plan):
        try:
            waypoints = np.asarray(action.waypoints, dtype=float)
        except (TypeError, ValueError) as error:
            message = "act returned a Plan whose waypoints are not numbers."
            raise AgentError(message) from error
        if waypoints.shape != (PLAN_STEPS, 2) or not np.isfinite(waypoints).all():
            message = (
                f"act returned a Plan of shape {waypoints.shape}: ({PLAN_STEPS}, 2) finite "
                "waypoints in the ego frame are wanted."
            )
            raise AgentError(message)
        return Plan(waypoints)
    message = f"act returned a {type(action).__name__}: a Plan or a Control is wanted."
    raise AgentError(message)


def same_action(one: Plan | Control, other: Plan | Control) -> bool:
    """Tell whether two actions are equal, number for number."""
    if isinstance(one, Plan) and isinstance(other, Plan):
        return bool(np.array_equal(one.waypoints, other.waypoints))
    return isinstance(one, Control) and one == other


def check_agent(agent: object, route: Route, observations: list[Observation]) -> None:
    """Check a planner against the contract, by driving it through given observations twice.

    `reset` must clear its memory: the same observations give the same actions. Actions must be
    valid, and observations must be left as they were.

    Args:
        agent: The planner.
        route: A route to reset it with.
        observations: A few ticks of one episode, for instance from a recording.

    Raises:
        AgentError: What it did, and what was wanted.
    """
    if not isinstance(agent, Agent):
        message = f"{type(agent).__name__} is no Agent: inputs, reset and act are wanted."
        raise AgentError(message)
    check_inputs(agent.inputs, type(agent).__name__)
    decision_interval(agent)
    given = route if Input.ROUTE in agent.inputs else None
    drives: list[list[Plan | Control]] = []
    for _ in range(2):
        agent.reset(given)
        actions = []
        for observation in observations:
            before = copy.deepcopy(observation)
            actions.append(check_action(agent.act(observation)))
            _check_reason(agent, observation)
            if not _equal(before, observation):
                message = f"{type(agent).__name__}.act changed its observation: it must not."
                raise AgentError(message)
        drives.append(actions)
    if not all(map(same_action, *drives)):
        message = f"{type(agent).__name__} acts differently after reset: it must forget the past."
        raise AgentError(message)
    if isinstance(agent, Ranker):
        _check_ranks(agent, observations)


def _check_reason(agent: Agent, observation: Observation) -> None:
    reason = reason_of(agent)
    if reason is None or reason.actor == NOBODY:
        return
    if observation.actors is None or reason.actor not in observation.actors.ids:
        message = f"explain returned actor {reason.actor}: the id of one in sight is wanted."
        raise AgentError(message)


def _check_ranks(agent: Ranker, observations: list[Observation]) -> None:
    for observation in observations:
        ranks = np.asarray(agent.rank(observation))
        count = 0 if observation.actors is None else len(observation.actors)
        if ranks.shape != (count,) or not np.isfinite(ranks).all():
            message = f"rank returned shape {ranks.shape}: ({count},) finite values are wanted."
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
