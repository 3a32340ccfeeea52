"""Runs tasks in warm worker processes; a worker that dies costs one retry and nothing else.

Each worker is a spawned process with a pipe of its own. `ProcessPoolExecutor` gives up the whole
pool when one worker dies and cannot tell whose task killed it; a shared queue can be left locked by
a killed worker. With a pipe each, the parent knows what each worker was doing, and reads all that a
worker said before it died.
"""

import os
import signal
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import connection, get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.worker import Done, Failed, Message, Ready, Share, Work, serve

TRIES = 2  # a task that fails this often is lost
STARTS = 3  # workers that die in a row before they are ready end the run
_THREAD_LIMITS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True, slots=True)
class Started:
    """A worker has begun a task; a second try begins anew."""

    worker: int
    task: int


@dataclass(frozen=True, slots=True)
class Progressed:
    """How far a worker is with its task, 0 to 1."""

    worker: int
    task: int
    share: float


@dataclass(frozen=True, slots=True)
class Finished:
    """A task has given a value."""

    worker: int
    task: int
    value: Any


@dataclass(frozen=True, slots=True)
class Retried:
    """A task has failed and will be tried again."""

    worker: int
    task: int
    reason: str


@dataclass(frozen=True, slots=True)
class Lost:
    """A task has failed `TRIES` times."""

    worker: int
    task: int
    reason: str


Event = Started | Progressed | Finished | Retried | Lost
Listener = Callable[[Event], None]


def run_tasks(
    tasks: Sequence[Any],
    work: Work,
    *,
    workers: int,
    on_event: Listener,
    logs: Path | None = None,
) -> None:
    """Run all tasks, begun in the given order as workers become free.

    What a worker raises, or its death, costs the task one of its `TRIES`; the other tasks go on.
    Any exception here, Ctrl-C included, ends all workers at once.

    Args:
        tasks: Picklable values.
        work: An importable function that is given a task and a callback for its progress.
        workers: Number of processes.
        on_event: Called in this process, one event after the other.
        logs: Folder that takes what workers print; without it they print to the terminal.

    Raises:
        InputError: A worker raised one, or met an error such as a full disk.
        SimulationError: Worker processes do not start.
    """
    pool = _Pool(tasks, work, on_event, logs)
    try:
        for number in range(min(workers, len(tasks))):
            pool.start(number)
        while pool.busy():
            pool.listen()
    finally:
        pool.stop()


@dataclass(slots=True)
class _Worker:
    number: int
    process: SpawnProcess
    pipe: Connection
    ready: bool = False
    task: int | None = None


class _Pool:
    """Worker processes and what they have to do; changes with each message that comes in."""

    def __init__(
        self, tasks: Sequence[Any], work: Work, on_event: Listener, logs: Path | None
    ) -> None:
        self._tasks = tasks
        self._work = work
        self._on_event = on_event
        self._logs = logs
        self._workers: list[_Worker] = []
        self._waiting = deque(range(len(tasks)))
        self._failures: Counter[int] = Counter()
        self._stillborn = 0  # workers in a row that died before they were ready

    def start(self, number: int) -> None:
        """Start a worker in a process of its own."""
        context = get_context("spawn")
        ours, theirs = context.Pipe()
        log = None if self._logs is None else self._logs / f"worker{number}.log"
        process = context.Process(target=serve, args=(theirs, self._work, log), daemon=True)
        with _child_settings():
            process.start()
            self._workers.append(_Worker(number, process, ours))
        theirs.close()

    def stop(self) -> None:
        """End all workers at once, whatever they do."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.process.join()
            worker.pipe.close()
        self._workers.clear()

    def busy(self) -> bool:
        """Tell whether a task waits or is worked on."""
        return bool(self._waiting) or any(worker.task is not None for worker in self._workers)

    def listen(self) -> None:
        """Wait until workers say something, and answer them."""
        speaking = connection.wait([worker.pipe for worker in self._workers])
        for worker in [worker for worker in self._workers if worker.pipe in speaking]:
            try:
                message: Message | None = worker.pipe.recv()
            except (EOFError, OSError):
                message = None
            if message is None:
                self._bury(worker)
            else:
                self._hear(worker, message)

    def _hear(self, worker: _Worker, message: Message) -> None:
        task = worker.task
        if isinstance(message, Ready):
            worker.ready = True
            self._stillborn = 0
            self._give(worker)
        elif isinstance(message, Share) and task is not None:
            self._on_event(Progressed(worker.number, task, message.share))
        elif isinstance(message, Done) and task is not None:
            worker.task = None
            self._on_event(Finished(worker.number, task, message.value))
            self._give(worker)
        elif isinstance(message, Failed):
            if message.fatal:
                raise InputError(message.reason)
            self._fail(worker, message.reason)
            self._replace(worker)  # what failed may have left the simulator in any state

    def _give(self, worker: _Worker) -> None:
        if not self._waiting:
            return
        worker.task = self._waiting.popleft()
        try:
            worker.pipe.send(self._tasks[worker.task])
        except OSError:
            return  # it has died: its pipe will tell
        self._on_event(Started(worker.number, worker.task))

    def _fail(self, worker: _Worker, reason: str) -> None:
        task, worker.task = worker.task, None
        if task is None:
            return
        self._failures[task] += 1
        if self._failures[task] < TRIES:
            self._waiting.appendleft(task)
            self._on_event(Retried(worker.number, task, reason))
        else:
            self._on_event(Lost(worker.number, task, reason))

    def _bury(self, worker: _Worker) -> None:
        worker.process.join()
        reason = _cause_of_death(worker.process.exitcode or 0)
        if not worker.ready:
            self._stillborn += 1
            if self._stillborn >= STARTS:
                where = "" if self._logs is None else f" See {self._logs}."
                message = f"Worker processes do not start. {reason}{where}"
                raise SimulationError(message)
        self._fail(worker, reason)
        self._replace(worker)

    def _replace(self, worker: _Worker) -> None:
        worker.process.kill()
        worker.process.join()
        worker.pipe.close()
        self._workers.remove(worker)
        if self._waiting:
            self.start(worker.number)


def _cause_of_death(code: int) -> str:
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
