"""Main loop of a worker process: receives tasks, reports progress, returns results."""

import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from plant_bench.errors import InputError, SimulationError
from plant_bench.gc_policy import tune_garbage_collector

REPORT_EVERY = 0.2  # s between two progress reports

Report = Callable[[float], None]
Work = Callable[[Any, Report], Any]  # must be importable: it is pickled by name


@dataclass(frozen=True, slots=True)
class Ready:
    """The worker has started and is ready for a task."""


@dataclass(frozen=True, slots=True)
class Share:
    """How far the worker is with its task, 0 to 1."""

    share: float


@dataclass(frozen=True, slots=True)
class Done:
    """What the task gave."""

    value: Any


@dataclass(frozen=True, slots=True)
class Failed:
    """What went wrong; `fatal` where the next task would fail the same way."""

    reason: str
    fatal: bool = False


@dataclass(frozen=True, slots=True)
class Assignment:
    """What a process that stands by is to do.

    Attributes:
        work: As of `serve`.
        log: As of `serve`.
    """

    work: Work
    log: Path | None


Message = Ready | Share | Done | Failed


def stand_by(pipe: Connection, load: Callable[[], object]) -> None:
    """Load what will be needed, then `serve` with the `Assignment` that the pipe tells.

    Args:
        pipe: To the parent.
        load: Loads it. What fails is left to the work, which says why.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tune_garbage_collector()
    with suppress(Exception):
        load()
    try:
        told = pipe.recv()
    except (EOFError, OSError):
        return
    serve(pipe, told.work, told.log)


def serve(pipe: Connection, work: Work, log: Path | None) -> None:
    """Do tasks until the parent is gone.

    Args:
        pipe: To the parent.
        work: Is given each task and a callback for its progress.
        log: File that takes all that is printed; None leaves it on the terminal.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which decides
    if log is not None:
        _print_to(log)
    tune_garbage_collector()
    last_report = 0.0

    def report(share: float) -> None:
        nonlocal last_report
        now = time.monotonic()
        if now - last_report >= REPORT_EVERY:
            last_report = now
            _say(pipe, Share(float(share)))

    _say(pipe, Ready())
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer = Done(work(task, report))
        except Exception as error:  # noqa: BLE001  a failure of any kind is this worker's answer
            traceback.print_exc()
            answer = failure(error)
        sys.stdout.flush()
        _say(pipe, answer)


def failure(error: Exception) -> Failed:
    """Say what an exception means for the run, in words that do not depend on the machine."""
    if isinstance(error, InputError):
        return Failed(str(error), fatal=True)
    if isinstance(error, OSError):
        return Failed(f"A worker cannot go on: {error}.", fatal=True)
    if isinstance(error, SimulationError):
        return Failed(str(error))
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return Failed(f"{type(error).__name__}: {error} ({Path(frame.filename).name}:{frame.lineno})")


def _say(pipe: Connection, message: Message) -> None:
    try:
        pipe.send(message)
    except OSError:
        os._exit(1)  # the parent is gone


def _print_to(log: Path) -> None:
    """Send all that this process prints, C code included, to a file."""
    descriptor = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)
