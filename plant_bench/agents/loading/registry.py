"""Creates a planner from its name, module or file, or starts its command."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

from plant_bench.agent import Agent
from plant_bench.agents.loading.planner_spec import Kind, PlannerSpec
from plant_bench.errors import AgentError, InputError
from plant_bench.sensing.inputs import check_inputs
from plant_bench.user_code import loading_error
from plant_bench.user_modules import load_module, load_named

Loader = Callable[[str], Agent]  # creates a planner from its name


def load_agent(text: str) -> Agent:
    """Return a new planner.

    Args:
        text: The planner's name, see `plant_bench.agents.loading.planner_spec`.

    Raises:
        InputError: There is no such planner, or the object is not one.
    """
    spec = PlannerSpec.parse(text)
    if spec.kind is Kind.COMMAND:
        return _command_agent(text)
    factory = agent_factory(text)
    try:
        agent = factory() if spec.argument is None else factory(spec.argument)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise loading_error(f"The agent '{text}' cannot be created", error) from error
    if not isinstance(agent, Agent):
        message = (
            f"'{text}' is not a planner: expected the attributes inputs, reset and act "
            "(plant_bench/agent.py)."
        )
        raise InputError(message)
    try:
        check_inputs(agent.inputs, f"'{text}'")
    except (AgentError, TypeError) as error:
        raise InputError(str(error)) from error
    return agent


def describe_agent(text: str) -> tuple[str, frozenset[str]]:
    """Return the first line of a planner's docstring, and its inputs.

    A class that declares its inputs is not instantiated, since its weights may be missing.

    Raises:
        InputError: There is no such planner.
    """
    factory = agent_factory(text)
    inputs = getattr(factory, "inputs", None)
    description = (factory.__doc__ or "").strip().partition("\n")[0]
    return description, load_agent(text).inputs if inputs is None else inputs


def agent_factory(text: str) -> Any:
    """Return a planner's class or factory function.

    Raises:
        InputError: There is no such class.
    """
    spec = PlannerSpec.parse(text)
    return load_named(spec.module, spec.name, f"agent '{text}'")


def planner_module(text: str) -> ModuleType:
    """Return the module of a planner's class.

    Raises:
        InputError: It does not exist or cannot be loaded.
    """
    return load_module(PlannerSpec.parse(text).module, f"agent '{text}'")


def _command_agent(text: str) -> Agent:
    from plant_bench.agents.remote.launch_command import launch_command_of
    from plant_bench.agents.remote.process import Limits
    from plant_bench.agents.remote.remote_agent import remote_agent

    return remote_agent(launch_command_of(text), Limits())
