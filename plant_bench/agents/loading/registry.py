"""Loads a planner by its name, its module or its file, or starts the command that runs it."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

from plant_bench.agent import Agent
from plant_bench.agents.loading.planner_spec import Kind, PlannerSpec
from plant_bench.errors import AgentError, InputError
from plant_bench.sensing.inputs import check_inputs
from plant_bench.user_modules import load_module, load_named

Loader = Callable[[str], Agent]  # makes a planner of its name


def load_agent(text: str) -> Agent:
    """Return a new planner.

    Args:
        text: Names it, see `plant_bench.agents.loading.planner_spec`.

    Raises:
        InputError: There is no such planner, or it is none; says what was meant perhaps.
    """
    spec = PlannerSpec.parse(text)
    if spec.kind is Kind.COMMAND:
        return _commanded(text)
    factory = agent_factory(text)
    try:
        agent = factory() if spec.argument is None else factory(spec.argument)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        message = f"The agent '{text}' cannot be made: {type(error).__name__}: {error}"
        raise InputError(message) from error
    if not isinstance(agent, Agent):
        message = f"'{text}' is no agent: inputs, reset and act are wanted (plant_bench/agent.py)."
        raise InputError(message)
    try:
        check_inputs(agent.inputs, f"'{text}'")
    except (AgentError, TypeError) as error:
        raise InputError(str(error)) from error
    return agent


def describe_agent(text: str) -> tuple[str, frozenset[str]]:
    """Return the first line of what a planner says of itself, and what it wants to be given.

    A class that declares its inputs is not made: it may want weights that are not there.

    Raises:
        InputError: There is no such planner.
    """
    made_by = agent_factory(text)
    inputs = getattr(made_by, "inputs", None)
    about = (made_by.__doc__ or "").strip().partition("\n")[0]
    return about, load_agent(text).inputs if inputs is None else inputs


def agent_factory(text: str) -> Any:
    """Return a planner's class, or the function that makes it, without making one.

    Raises:
        InputError: There is no such class.
    """
    spec = PlannerSpec.parse(text)
    return load_named(spec.module, spec.name, f"agent '{text}'")


def planner_module(text: str) -> ModuleType:
    """Return the module that a planner's class is taken from.

    Raises:
        InputError: There is none, or it cannot be loaded.
    """
    return load_module(PlannerSpec.parse(text).module, f"agent '{text}'")


def _commanded(text: str) -> Agent:
    from plant_bench.agents.remote.launch_command import launch_command_of
    from plant_bench.agents.remote.process import Limits
    from plant_bench.agents.remote.remote_agent import remote_agent

    return remote_agent(launch_command_of(text), Limits())
