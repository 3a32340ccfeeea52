"""A planner's process while a planner of ours needs it; behaved processes are taken over."""

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
from plant_bench.agents.remote.responses import Hello, answer_in
from plant_bench.errors import AgentError, InputError
from plant_bench.sensing.inputs import check_inputs


@dataclass(frozen=True)
class Profile:
    """What a planner in another process said of itself.

    Attributes:
        inputs: What it wants to be given.
        interval: Ticks between two decisions, before the first one.
        ranks: Whether it ranks actors.
        files: All that it is made of.
        libraries: Packages of Python that it computes with.
    """

    inputs: frozenset[str]
    interval: int
    ranks: bool
    files: tuple[Path, ...]
    libraries: tuple[str, ...] = ()


class Connection:
    """Questions to one planner of a program; mutable. Who does not answer well is ended."""

    def __init__(self, program: LaunchCommand, limits: Limits) -> None:
        self.program = program
        self._limits = limits
        self._process: PlannerProcess | None = None

    @property
    def alive(self) -> bool:
        """Whether its process runs."""
        return self._process is not None and self._process.alive

    def begin(self) -> Profile:
        """Take a process, make a new planner in it, and return what it says of itself.

        Raises:
            RemoteError: It does not start, or says something unheard of.
        """
        key = (self.program, self._limits)
        process = _idle.pop(key, None) or PlannerProcess(self.program.command, self._limits)
        _running.add(process)
        weakref.finalize(self, _give_back, key, process)
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

    def ask(self, question: Wire, *wanted: type, starting: bool = False) -> Any:
        """Return the answer to a question.

        Args:
            question: As `messages` makes it.
            wanted: The kinds of answers that may come.
            starting: Whether it has the time to start up, not that of a decision.

        Raises:
            RemoteError: What came instead.
        """
        process = self._process
        if process is None:
            message = "it was asked before reset."
            raise ProtocolError(message)
        seconds, limit = self._limits.tick, "--tick-limit"
        if starting:
            seconds, limit = self._limits.start_up, "--start-up-limit"
        try:
            return answer_in(process.ask(pack(question), seconds, limit), *wanted)
        except RemoteError as error:
            process.close()
            if type(error).__name__ == MemoryError.__name__:
                raise memory_limit(self._limits) from error
            raise

    def array(self, wire: Any, *, axes: int) -> np.ndarray:
        """Return the array of an answer.

        Raises:
            ProtocolError: It is none, or has another number of axes.
        """
        try:
            values = array_in(wire, FLOAT64)
            if values.ndim != axes:
                message = f"an array of {axes} axes is wanted, not of {values.ndim}."
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


_idle: dict[tuple[LaunchCommand, Limits], PlannerProcess] = {}  # behaved well and may be taken over
_running: weakref.WeakSet[PlannerProcess] = weakref.WeakSet()


def _give_back(key: tuple[LaunchCommand, Limits], process: PlannerProcess) -> None:
    """Keep a process for the next planner of the same program."""
    if process.alive and key not in _idle:
        _idle[key] = process
    else:
        process.close()


def end_processes() -> None:
    """End all planners' processes that this process has started."""
    for process in list(_running):
        process.close()
    _idle.clear()


atexit.register(end_processes)
