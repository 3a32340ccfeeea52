"""What can go wrong with a planner in another process.

A record says "act raised <name>: <text>", so the names of these classes are part of what users
read. No text holds what differs between equal runs: no times, sizes or addresses.
"""

import re

from plant_bench.errors import LONGEST, AgentError
from plant_bench.foreign_text import one_line

_ADDRESS = re.compile(r"\b0x[0-9a-fA-F]+")
_NAME = re.compile(r"[A-Za-z_]\w{0,60}")


class RemoteError(AgentError):
    """Base of what a planner in another process can do wrong."""


class TimeLimitError(RemoteError):
    """Raised when it does not answer in time."""


class MemoryLimitError(RemoteError):
    """Raised when its processes hold more memory than they may."""


class ProcessEndedError(RemoteError):
    """Raised when its process is gone, or has closed its pipe."""


class ProtocolError(RemoteError):
    """Raised when what it says is not what docs/reference/protocol-agents.md asks for."""


def raised_remotely(error: str, message: str) -> RemoteError:
    """Return what a planner says that its own code raised, under the name it had there.

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
