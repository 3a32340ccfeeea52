"""Starts worker processes with one thread each, which ignore Ctrl-C."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

_THREAD_LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def start_process(target: Callable[..., None], *given: object) -> tuple[SpawnProcess, Connection]:
    """Start a process with one thread that is deaf to Ctrl-C.

    Args:
        target: What it runs: an importable function.
        given: Its arguments; a pipe to this process comes before them.

    Returns:
        The process, and our end of the pipe.
    """
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=target, args=(theirs, *given), daemon=True)
    with _child_settings():
        process.start()
    theirs.close()
    return process, ours


def cause_of_death(code: int) -> str:
    """Say how a process ended, of its exit code."""
    if code < 0:
        return f"The worker process was ended by {signal.Signals(-code).name}."
    return f"The worker process ended with exit code {code}."


@contextmanager
def _child_settings() -> Iterator[None]:
    """Let children inherit one thread each, and deafness to Ctrl-C from their first line on."""
    before = {name: os.environ.get(name) for name in _THREAD_LIMITS}
    os.environ.update(dict.fromkeys(_THREAD_LIMITS, "1"))
    can_block = hasattr(signal, "pthread_sigmask")
    mask: set[int] = set()
    if can_block:
        resource_tracker.ensure_running()  # its own start would lift the block
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value
        if can_block:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
