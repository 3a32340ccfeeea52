"""Graceful Ctrl-C: finishes the current step and writes the checkpoint before exiting."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


@dataclass
class StopRequest:
    """Whether a stop was requested; mutable."""

    wanted: bool = False


@contextmanager
def stop_wish() -> Iterator[StopRequest]:
    """Within the context, turn the first Ctrl-C into a stop request; the second one raises."""
    wish = StopRequest()

    def hear(_signal: int, _frame: FrameType | None) -> None:
        if wish.wanted:
            raise KeyboardInterrupt
        wish.wanted = True

    before = signal.signal(signal.SIGINT, hear)
    try:
        yield wish
    finally:
        signal.signal(signal.SIGINT, before)
