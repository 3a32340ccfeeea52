"""Measures the time of a planner's forward passes; their median is its inference time (IT).

    with forward_pass(tokens=len(objects)):
        waypoints = network(objects)

Only the network belongs inside: neither features before it nor control after it. Without a listener
nothing is recorded, so planners may always measure. Times are passed through a context variable:
wrapped planners need not forward them, and no action depends on the clock.
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
        seconds: Wall time, seconds.
        tokens: Number of input objects.
    """

    seconds: float
    tokens: int


_listener: ContextVar[list[ForwardPass] | None] = ContextVar("forward passes", default=None)


def listen_to_passes() -> list[ForwardPass]:
    """Return a list to which all forward passes are appended until the next call."""
    passes: list[ForwardPass] = []
    _listener.set(passes)
    return passes


@contextmanager
def forward_pass(tokens: int) -> Iterator[None]:
    """Time the body as one forward pass over `tokens` objects."""
    begin = time.perf_counter()
    yield
    record_pass(ForwardPass(time.perf_counter() - begin, tokens))


def record_pass(done: ForwardPass) -> None:
    """Record a forward pass that was timed elsewhere, for instance in another process."""
    passes = _listener.get()
    if passes is not None:
        passes.append(done)
