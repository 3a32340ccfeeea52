"""Errors of planners in other processes.

Records say "act raised <name>: <text>", so users see the names of these classes. The texts have
nothing that differs between equal runs: no measured times, sizes or addresses.
"""

import re

from plant_bench.errors import LONGEST, AgentError
from plant_bench.text_escaping import one_line

_ADDRESS = re.compile(r"\b0x[0-9a-fA-F]+")
_NAME = re.compile(r"[A-Za-z_]\w{0,60}")


class RemoteError(AgentError):
    """Base of the errors of planners in other processes."""


class TimeLimitError(RemoteError):
    """Raised when a planner does not respond in time."""


class MemoryLimitError(RemoteError):
    """Raised when a planner's processes exceed the memory limit."""


class ProcessEndedError(RemoteError):
    """Raised when a planner's process has ended or closed its pipe."""


class ProtocolError(RemoteError):
    """Raised when a message violates docs/reference/protocol-agents.md."""


def raised_remotely(error: str, message: str) -> RemoteError:
    """Return an exception that a planner's code raised, under its original class name.

    >>> type(raised_remotely("ValueError", "no lane")).__name__
    'ValueError'
    >>> str(raised_remotely("KeyError", "<Lane at 0x7f12ab>"))
    '<Lane at 0x...>'
    """
    name = error if _NAME.fullmatch(error) else "RemoteError"
    return type(name, (RemoteError,), {})(tidy(message))


def tidy(message: str) -> str:
    """Return a planner's text as one line of bounded length, without addresses."""
    text = " ".join(_ADDRESS.sub("0x...", message).split())
    return one_line(text, LONGEST, instead="?")
