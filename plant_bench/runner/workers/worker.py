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

from plant_bench.data_files import make_towns_variable_absolute
from plant_bench.errors import InputError, SimulationError, UserCodeError
from plant_bench.gc_policy import tune_garbage_collector
from plant_bench.runner.workers.window import WINDOW_CLOSED, is_window_closed
from plant_bench.user_code import PLANNER_LOG, working_folder

WORKER_EXITED = "The worker process ended with exit code"
REPORT_EVERY = 0.2  # s between two progress reports

Report = Callable[[float], None]
Work = Callable[[Any, Report], Any]  # must be importable: it is pickled by name


@dataclass(frozen=True, slots=True)
class Ready:
    """The worker has started and is ready for a task."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of the worker's task, 0 to 1."""

    share: float


@dataclass(frozen=True, slots=True)
class TaskResult:
    """The value that the task returned."""

    value: Any


@dataclass(frozen=True, slots=True)
class Failed:
    """The task failed.

    Attributes:
        reason: Why.
        fatal: Whether every other task would fail in the same way.
        logged: Whether the worker's log has the traceback of a planner's own code.
        exited: Whether the process has ended with an exit code, which SUMO does not do.
    """

    reason: str
    fatal: bool = False
    logged: bool = False
    exited: bool = False


@dataclass(frozen=True, slots=True)
class Assignment:
    """Makes a standby process a worker; the arguments of `serve`."""

    work: Work
    log: Path | None


Message = Ready | Progress | TaskResult | Failed


def serve_on_standby(pipe: Connection, preload: Callable[[], object]) -> None:
    """Preload modules, wait for an `Assignment` from the pipe, then `serve`.

    Args:
        pipe: To the parent.
        preload: Imports modules. Its errors are ignored: the task raises them again.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tune_garbage_collector()
    with suppress(Exception):
        preload()
    try:
        assignment: Assignment = pipe.recv()
    except (EOFError, OSError):
        return
    serve(pipe, assignment.work, assignment.log)


def serve(pipe: Connection, work: Work, log: Path | None) -> None:
    """Run tasks until the parent closes the pipe.

    Args:
        pipe: To the parent.
        work: Called with each task and a progress callback.
        log: File for all output of the process; None to print to the terminal.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which decides
    if log is not None:
        _redirect_output(log)
        os.environ[PLANNER_LOG] = str(log.absolute())
    make_towns_variable_absolute()
    folder = working_folder()
    tune_garbage_collector()
    last_report = 0.0

    def report(share: float) -> None:
        nonlocal last_report
        now = time.monotonic()
        if now - last_report >= REPORT_EVERY:
            last_report = now
            _send(pipe, Progress(float(share)))

    _send(pipe, Ready())
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError):
            return
        if folder is not None:
            os.chdir(folder)  # the planner of the last task may have changed it
        try:
            message: Message = TaskResult(work(task, report))
        except Exception as error:  # noqa: BLE001  sent to the parent
            # A user's code has logged its traceback, and a closed window needs none.
            told = isinstance(error, UserCodeError) or is_window_closed(error)
            by_parent = log is None and isinstance(error, InputError)  # the parent prints it
            if not told and not by_parent:
                traceback.print_exc()
            message = failure(error)
        sys.stdout.flush()
        _send(pipe, message)


def failure(error: Exception) -> Failed:
    """Return the failure message of an exception; its text does not depend on the machine."""
    if isinstance(error, InputError):
        return Failed(str(error), fatal=True, logged=isinstance(error, UserCodeError))
    if is_window_closed(error):
        return Failed(WINDOW_CLOSED, fatal=True)
    if isinstance(error, OSError):
        return Failed(f"A worker cannot go on: {error}.", fatal=True)
    if isinstance(error, SimulationError):
        return Failed(str(error))
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return Failed(f"{type(error).__name__}: {error} ({Path(frame.filename).name}:{frame.lineno})")


def exit_failure(code: int) -> Failed:
    """Return the failure message of a process that has ended, from its exit code."""
    if code < 0:
        return Failed(f"The worker process was ended by {signal.Signals(-code).name}.")
    return Failed(f"{WORKER_EXITED} {code}.", exited=True)


def _send(pipe: Connection, message: Message) -> None:
    try:
        pipe.send(message)
    except OSError:
        os._exit(1)  # the parent is gone


def _redirect_output(log: Path) -> None:
    """Redirect all output of this process, including that of C code, to a file."""
    descriptor = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)
