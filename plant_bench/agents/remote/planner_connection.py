"""Connection to a remote planner's process, which later planners reuse unless it failed."""

import atexit
import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plant_bench.agents.remote.codec import FLOAT64, array_in, pack
from plant_bench.agents.remote.launch_command import LaunchCommand
from plant_bench.agents.remote.messages import Wire, hello_out
from plant_bench.agents.remote.process import Limits, PlannerProcess, memory_limit
from plant_bench.agents.remote.remote_errors import ProtocolError, RemoteError
from plant_bench.agents.remote.responses import Hello, response_in
from plant_bench.errors import AgentError, InputError
from plant_bench.sensing.inputs import check_inputs


@dataclass(frozen=True)
class Profile:
    """The properties that a remote planner reports.

    Attributes:
        inputs: The inputs that it declares.
        interval: Ticks from its first decision to its second.
        ranks: Whether it ranks actors.
        files: Its code and weights.
        libraries: The Python packages that its computations use.
    """

    inputs: frozenset[str]
    interval: int
    ranks: bool
    files: tuple[Path, ...]
    libraries: tuple[str, ...] = ()


class Connection:
    """Sends requests to one planner; ends its process at the first invalid response; mutable."""

    def __init__(self, program: LaunchCommand, limits: Limits) -> None:
        self.program = program
        self._limits = limits
        self._process: PlannerProcess | None = None

    @property
    def alive(self) -> bool:
        """Whether its process runs."""
        return self._process is not None and self._process.alive

    def begin(self) -> Profile:
        """Start or reuse a process, create a new planner in it, and return its profile.

        Raises:
            RemoteError: It does not start, or its response is invalid.
        """
        key = (self.program, self._limits)
        process = _idle.pop(key, None) or PlannerProcess(self.program.command, self._limits)
        _running.add(process)
        weakref.finalize(self, _release, key, process)
        self._process = process
        hello: Hello = self.ask(hello_out(self.program.agent), Hello, starting=True)
        try:
            check_inputs(hello.inputs, "it")
        except AgentError as error:
            self.close()
            raise ProtocolError(str(error)) from error
        inputs = frozenset(hello.inputs)
        files = (*self.program.files, *map(Path, hello.files))
        return Profile(inputs, hello.interval, hello.ranks, files, tuple(hello.libraries))

    def ask(self, request: Wire, *expected: type, starting: bool = False) -> Any:
        """Send a request and return the response.

        Args:
            request: The request, from `messages`.
            expected: The allowed types of the response.
            starting: Use the time limit for starting up, not that for a decision.

        Raises:
            RemoteError: There was no valid response.
        """
        process = self._process
        if process is None:
            message = "expected reset as the first call."
            raise ProtocolError(message)
        seconds, limit = self._limits.tick, "--tick-limit"
        if starting:
            seconds, limit = self._limits.start_up, "--start-up-limit"
        try:
            return response_in(process.ask(pack(request), seconds, limit), *expected)
        except RemoteError as error:
            process.close()
            if type(error).__name__ == MemoryError.__name__:
                raise memory_limit(self._limits) from error
            raise

    def array(self, wire: Any, *, axes: int) -> np.ndarray:
        """Decode an array in a response.

        Raises:
            ProtocolError: It is not an array, or has another number of axes.
        """
        try:
            values = array_in(wire, FLOAT64)
            if values.ndim != axes:
                message = f"expected an array of {axes} axes, got {values.ndim}."
                raise ProtocolError(message)
        except ProtocolError:
            self.close()
            raise
        return values

    def close(self) -> None:
        """End its process."""
        if self._process is not None:
            self._process.close()


def first_profile(connection: Connection) -> Profile:
    """Start a planner for the first time.

    Raises:
        InputError: It does not start.
    """
    try:
        return connection.begin()
    except RemoteError as error:
        if type(error).__name__ == InputError.__name__:
            raise InputError(str(error)) from error
        message = (
            f"The agent '{connection.program.spec}' does not start: {type(error).__name__}: {error}"
        )
        raise InputError(message) from error


_idle: dict[tuple[LaunchCommand, Limits], PlannerProcess] = {}  # to be reused
_running: weakref.WeakSet[PlannerProcess] = weakref.WeakSet()


def _release(key: tuple[LaunchCommand, Limits], process: PlannerProcess) -> None:
    """Keep a process for the next planner with the same command."""
    if process.alive and key not in _idle:
        _idle[key] = process
    else:
        process.close()


def end_processes() -> None:
    """End all planner processes that this process has started."""
    for process in list(_running):
        process.close()
    _idle.clear()


atexit.register(end_processes)
