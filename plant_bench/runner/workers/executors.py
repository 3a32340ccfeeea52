"""Runs tasks in warm worker processes; a worker that dies costs one retry and nothing else.

`Executor` is what a run needs of whoever runs its tasks: `LocalExecutor` does so in processes of
this machine, `runner.ray.executor` on a Ray cluster. Both tell the same events.

Each worker is a spawned process with a pipe of its own. `ProcessPoolExecutor` gives up the whole
pool when one worker dies and cannot tell whose task killed it; a shared queue can be left locked by
a killed worker. With a pipe each, the parent knows what each worker was doing, and reads all that a
worker said before it died.
"""

from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.workers.process_start import cause_of_death, start_process
from plant_bench.runner.workers.worker import (
    Assignment,
    Done,
    Failed,
    Message,
    Ready,
    Share,
    Work,
    serve,
    stand_by,
)

TRIES = 2  # a task that fails this often is lost
STANDING_BY = 2  # workers that load what they need before it is known how many there will be
STARTS = 3  # workers that die in a row before they are ready end the run


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
Keep = Callable[[str, bytes], None]
_Process = tuple[SpawnProcess, Connection]


@runtime_checkable
class Executor(Protocol):
    """Runs tasks somewhere."""

    def connected(self) -> AbstractContextManager[None]:
        """Have what `run_tasks` needs ready beforehand, so that it fails before a run is begun.

        Raises:
            InputError: It is not there.
        """
        ...

    def run_tasks(
        self, tasks: Sequence[Any], work: Work, *, on_event: Listener, logs: Path, keep: Keep
    ) -> None:
        """Run all tasks, begun in the given order as workers become free.

        Args:
            tasks: Picklable values.
            work: An importable function that is given a task and a callback for its progress.
            on_event: Called in this process, one event after the other.
            logs: Folder that takes what workers print.
            keep: Writes a file that came back from another machine, by its path in the run's
                folder; not called by an executor whose workers write there themselves.

        Raises:
            InputError: No task can run like this.
            SimulationError: Workers do not start, or cannot be had any more.
        """
        ...


def _nothing() -> None:
    """Load nothing beforehand."""


class LocalExecutor:
    """Runs tasks in processes of this machine; mutable: it may have some that stand by.

    Args:
        workers: Number of processes.
        load: What they do while this process still finds out what there is to do; picklable.
    """

    def __init__(self, workers: int, load: Callable[[], object] = _nothing) -> None:
        self.workers = workers
        self._load = load
        self._waiting: list[_Process] = []
        self._connected = False

    def __str__(self) -> str:
        return f"{self.workers} workers"

    @contextmanager
    def connected(self) -> Iterator[None]:
        """Have processes load what they need; see `Executor`. Once more changes nothing."""
        if self._connected:
            yield
            return
        self._connected = True
        try:
            for _ in range(min(self.workers, STANDING_BY)):
                self._waiting.append(start_process(stand_by, self._load))
            yield
        finally:
            _end(self._waiting)
            self._waiting.clear()
            self._connected = False

    def run_tasks(
        self, tasks: Sequence[Any], work: Work, *, on_event: Listener, logs: Path, keep: Keep
    ) -> None:
        """Run all tasks; see `Executor` and the function `run_tasks`."""
        del keep  # workers here write into the run's folder themselves
        _end(self._waiting[len(tasks) :])
        del self._waiting[len(tasks) :]
        run_tasks(
            tasks,
            work,
            workers=self.workers,
            on_event=on_event,
            logs=logs,
            waiting=self._waiting,
        )


def _end(processes: Sequence[_Process]) -> None:
    """End processes at once, whatever they do."""
    for process, _ in processes:
        process.kill()
    for process, pipe in processes:
        process.join()
        pipe.close()


class Agenda:
    """Which tasks wait, and how often each has failed; mutable.

    Args:
        count: Number of tasks.
        on_event: Told of each failure.
    """

    def __init__(self, count: int, on_event: Listener) -> None:
        self.waiting = deque(range(count))
        self._on_event = on_event
        self._failures: Counter[int] = Counter()

    def fail(self, worker: int, task: int, reason: str) -> None:
        """Note a failure: the task is the next to be tried again, or lost."""
        self._failures[task] += 1
        if self._failures[task] < TRIES:
            self.waiting.appendleft(task)
            self._on_event(Retried(worker, task, reason))
        else:
            self._on_event(Lost(worker, task, reason))


def run_tasks(
    tasks: Sequence[Any],
    work: Work,
    *,
    workers: int,
    on_event: Listener,
    logs: Path | None = None,
    waiting: list[_Process] | None = None,
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
        waiting: Processes that stand by; those that are used are taken out.

    Raises:
        InputError: A worker raised one, or met an error such as a full disk.
        SimulationError: Worker processes do not start.
    """
    pool = _Pool(tasks, work, on_event, logs, [] if waiting is None else waiting)
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
    stood_by: bool
    ready: bool = False
    task: int | None = None


class _Pool:
    """Worker processes and what they have to do; changes with each message that comes in."""

    def __init__(
        self,
        tasks: Sequence[Any],
        work: Work,
        on_event: Listener,
        logs: Path | None,
        waiting: list[_Process],
    ) -> None:
        self._tasks = tasks
        self._work = work
        self._on_event = on_event
        self._logs = logs
        self._waiting = waiting
        self._workers: list[_Worker] = []
        self._agenda = Agenda(len(tasks), on_event)
        self._stillborn = 0  # workers in a row that died before they were ready

    def start(self, number: int) -> None:
        """Start a worker in a process of its own."""
        log = None if self._logs is None else self._logs / f"worker{number}.log"
        if self._waiting:
            process, pipe = self._waiting.pop(0)
            told = Assignment(self._work, log)
            with suppress(OSError):  # it has died: its pipe will tell
                pipe.send(told)
            stood_by = True
        else:
            process, pipe = start_process(serve, self._work, log)
            stood_by = False
        self._workers.append(_Worker(number, process, pipe, stood_by))

    def stop(self) -> None:
        """End all workers at once, whatever they do."""
        _end([(worker.process, worker.pipe) for worker in self._workers])
        self._workers.clear()

    def busy(self) -> bool:
        """Tell whether a task waits or is worked on."""
        return bool(self._agenda.waiting) or any(
            worker.task is not None for worker in self._workers
        )

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
        if not self._agenda.waiting:
            return
        worker.task = self._agenda.waiting.popleft()
        try:
            worker.pipe.send(self._tasks[worker.task])
        except OSError:
            return  # it has died: its pipe will tell
        self._on_event(Started(worker.number, worker.task))

    def _fail(self, worker: _Worker, reason: str) -> None:
        task, worker.task = worker.task, None
        if task is not None:
            self._agenda.fail(worker.number, task, reason)

    def _bury(self, worker: _Worker) -> None:
        worker.process.join()
        reason = cause_of_death(worker.process.exitcode or 0)
        if not worker.ready and not worker.stood_by:  # whoever comes next tells why
            self._stillborn += 1
            if self._stillborn >= STARTS:
                where = "" if self._logs is None else f" See {self._logs}."
                message = f"Worker processes do not start. {reason}{where}"
                raise SimulationError(message)
        self._fail(worker, reason)
        self._replace(worker)

    def _replace(self, worker: _Worker) -> None:
        _end([(worker.process, worker.pipe)])
        self._workers.remove(worker)
        if self._agenda.waiting:
            self.start(worker.number)
