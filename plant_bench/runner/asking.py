"""A planner is somebody else's code: whatever it raises ends its own episode, and nothing else."""

from collections.abc import Callable
from typing import Any

from plant_bench.errors import AgentError


def asked(what: str, call: Callable[..., Any], *given: object) -> Any:
    """Return what a planner's method answers.

    Args:
        what: Names the method, for the message.
        call: The method.
        given: Its arguments.

    Raises:
        AgentError: It raised something.
    """
    try:
        return call(*given)
    except (Exception, SystemExit) as error:
        message = f"{what} raised {type(error).__name__}: {error}"
        raise AgentError(message) from error
