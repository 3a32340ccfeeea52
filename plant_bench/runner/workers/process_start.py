"""Starts worker processes with one thread each, which ignore Ctrl-C."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

_THREAD_LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def start_process(
    target: Callable[..., None], *arguments: object
) -> tuple[SpawnProcess, Connection]:
    """Start a process with one thread that ignores Ctrl-C.

    Args:
        target: Importable function that the process runs.
        arguments: Arguments of `target`, after its first: the child's end of a pipe.

    Returns:
        The process, and the parent's end of the pipe.
    """
    context = get_context("spawn")
    parent_end, child_end = context.Pipe()
    process = context.Process(target=target, args=(child_end, *arguments), daemon=True)
    with _child_settings():
        process.start()
    child_end.close()
    return process, parent_end


@contextmanager
def _child_settings() -> Iterator[None]:
    """Let child processes inherit thread limits of one, and block Ctrl-C from their start."""
    before = {name: os.environ.get(name) for name in _THREAD_LIMITS}
    os.environ.update(dict.fromkeys(_THREAD_LIMITS, "1"))
    can_block = hasattr(signal, "pthread_sigmask")
    mask: set[int] = set()
    if can_block:
        resource_tracker.ensure_running()  # starting it later would unblock SIGINT
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
