"""Ctrl-C as a wish: the step at hand is finished, the checkpoint written, then all ends."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


@dataclass
class StopRequest:
    """Whether the user wants to stop; mutable."""

    wanted: bool = False


@contextmanager
def stop_wish() -> Iterator[StopRequest]:
    """Turn the first Ctrl-C into a wish for as long as the context lasts; the second one raises."""
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
