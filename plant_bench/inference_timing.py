"""Where a planner says what its forward passes took; their median is its inference time (IT).

    with forward_pass(tokens=len(objects)):
        waypoints = network(objects)

Only the network belongs in there: neither features before it nor control after it. Without a
listener nothing is kept, so a planner may always tell. It is told through the running context and
not returned: planners inside planners need not pass it on, and no action depends on the clock.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ForwardPass:
    """One pass of a network over one scene.

    Attributes:
        seconds: Wall time.
        tokens: Objects that it was given.
    """

    seconds: float
    tokens: int


_listener: ContextVar[list[ForwardPass] | None] = ContextVar("forward passes", default=None)


def listen_to_passes() -> list[ForwardPass]:
    """Return a list that grows with each forward pass from now on, until the next call of this."""
    passes: list[ForwardPass] = []
    _listener.set(passes)
    return passes


@contextmanager
def forward_pass(tokens: int) -> Iterator[None]:
    """Time what is done inside as one forward pass over so many tokens."""
    begin = time.perf_counter()
    yield
    tell_pass(ForwardPass(time.perf_counter() - begin, tokens))


def tell_pass(done: ForwardPass) -> None:
    """Tell of a forward pass that was timed elsewhere, in another process for instance."""
    passes = _listener.get()
    if passes is not None:
        passes.append(done)
