"""Runs tasks in reused worker processes; if a worker dies, only its task is retried.

`Executor` is the interface: `LocalExecutor` runs tasks in processes on this machine,
`runner.ray.executor` on a Ray cluster. Both report the same events.

Each worker is a spawned process with its own pipe. `ProcessPoolExecutor` abandons the whole pool
when one worker dies and cannot say which task killed it; a killed worker can leave a shared queue
locked. With one pipe per worker, the parent knows each worker's task and can read all messages that
a worker sent before it died.
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
from plant_bench.runner.workers.process_start import start_process
from plant_bench.runner.workers.worker import (
    Assignment,
    Failed,
    Message,
    Progress,
    Ready,
    TaskResult,
    Work,
    exit_failure,
    serve,
    serve_on_standby,
)
from plant_bench.user_code import with_log

MAX_ATTEMPTS = 2  # a task that fails this often is lost
STANDBY_WORKERS = 2  # started before the number of tasks is known, to preload modules
MAX_FAILED_STARTS = 3  # consecutive workers that die during start-up before the run is aborted


@dataclass(frozen=True, slots=True)
class Started:
    """A worker has started a task; sent again when the task is retried."""

    worker: int
    task: int


@dataclass(frozen=True, slots=True)
class Progressed:
    """Progress of a worker's task, 0 to 1."""

    worker: int
    task: int
    share: float


@dataclass(frozen=True, slots=True)
class Finished:
    """A task has returned a value."""

    worker: int
    task: int
    value: Any


@dataclass(frozen=True, slots=True)
class Retried:
    """A task has failed and will be retried."""

    worker: int
    task: int
    reason: str


@dataclass(frozen=True, slots=True)
class Lost:
    """A task has failed `MAX_ATTEMPTS` times; `exited` as in `Failed`."""

    worker: int
    task: int
    reason: str
    exited: bool = False


Event = Started | Progressed | Finished | Retried | Lost
Listener = Callable[[Event], None]
SaveFile = Callable[[str, bytes], None]
_Process = tuple[SpawnProcess, Connection]


@runtime_checkable
class Executor(Protocol):
    """Runs tasks in other processes."""

    def connected(self) -> AbstractContextManager[None]:
        """Prepare for `run_tasks`, so that connection errors surface before a run starts.

        Raises:
            InputError: The workers' machines cannot be reached.
        """
        ...

    def run_tasks(
        self,
        tasks: Sequence[Any],
        work: Work,
        *,
        on_event: Listener,
        logs: Path,
        save_file: SaveFile,
    ) -> None:
        """Run all tasks, started in the given order as workers become free.

        Args:
            tasks: Picklable values.
            work: An importable function of a task and a progress callback.
            on_event: Called in this process with each event.
            logs: Folder for the workers' output.
            save_file: Writes a file received from another machine; its arguments are a path in the
                run's folder and the content. Not called if workers write there themselves.

        Raises:
            InputError: An error that all tasks have in common.
            SimulationError: Workers do not start, or none are left.
        """
        ...


def _no_preload() -> None:
    """Preload no modules."""


class LocalExecutor:
    """Runs tasks in processes on this machine; mutable, since it holds standby processes.

    Args:
        workers: Number of processes.
        preload: Called in standby processes while this process prepares the tasks; picklable.
    """

    def __init__(self, workers: int, preload: Callable[[], object] = _no_preload) -> None:
        self.workers = workers
        self._preload = preload
        self._standby: list[_Process] = []
        self._connected = False

    def __str__(self) -> str:
        return f"{self.workers} workers"

    @contextmanager
    def connected(self) -> Iterator[None]:
        """Start standby processes that preload modules; nested calls have no effect."""
        if self._connected:
            yield
            return
        self._connected = True
        try:
            for _ in range(min(self.workers, STANDBY_WORKERS)):
                self._standby.append(start_process(serve_on_standby, self._preload))
            yield
        finally:
            _kill(self._standby)
            self._standby.clear()
            self._connected = False

    def run_tasks(
        self,
        tasks: Sequence[Any],
        work: Work,
        *,
        on_event: Listener,
        logs: Path,
        save_file: SaveFile,
    ) -> None:
        """Run all tasks; see `Executor` and the function `run_tasks`."""
        del save_file  # local workers write into the run's folder themselves
        _kill(self._standby[len(tasks) :])
        del self._standby[len(tasks) :]
        run_tasks(
            tasks,
            work,
            workers=self.workers,
            on_event=on_event,
            logs=logs,
            standby=self._standby,
        )


def log_name(worker: int) -> str:
    """Return the name of a worker's log."""
    return f"worker{worker}.log"


def fatal_error(failed: Failed, log: Path | None) -> InputError:
    """Return the error that ends a run after a fatal failure; it names the log of a traceback."""
    if failed.logged and log is not None:
        return InputError(with_log(failed.reason, log))
    return InputError(failed.reason)


def _kill(processes: Sequence[_Process]) -> None:
    """Kill processes and wait for their end."""
    for process, _ in processes:
        process.kill()
    for process, pipe in processes:
        process.join()
        pipe.close()


class TaskQueue:
    """Indices of pending tasks, and how often each task has failed; mutable.

    Args:
        count: Number of tasks.
        on_event: Called with each failure.
    """

    def __init__(self, count: int, on_event: Listener) -> None:
        self.pending = deque(range(count))
        self._on_event = on_event
        self._failures: Counter[int] = Counter()

    def fail(self, worker: int, task: int, failed: Failed) -> None:
        """Count a failure: the task is put first in the queue again, or lost."""
        self._failures[task] += 1
        if self._failures[task] < MAX_ATTEMPTS:
            self.pending.appendleft(task)
            self._on_event(Retried(worker, task, failed.reason))
        else:
            self._on_event(Lost(worker, task, failed.reason, failed.exited))


def run_tasks(
    tasks: Sequence[Any],
    work: Work,
    *,
    workers: int,
    on_event: Listener,
    logs: Path | None = None,
    standby: list[_Process] | None = None,
) -> None:
    """Run all tasks, started in the given order as workers become free.

    An exception in a worker, or its death, counts as one of the task's `MAX_ATTEMPTS`; the other
    tasks continue. Any exception in this process, including Ctrl-C, kills all workers.

    Args:
        tasks: Picklable values.
        work: An importable function of a task and a progress callback.
        workers: Number of processes.
        on_event: Called in this process with each event.
        logs: Folder for the workers' output; None to print to the terminal.
        standby: Standby processes; those that are used are removed from the list.

    Raises:
        InputError: Raised in a worker; also for operating-system errors such as a full disk.
        SimulationError: Worker processes do not start.
    """
    pool = _Pool(tasks, work, on_event, logs, [] if standby is None else standby)
    try:
        for number in range(min(workers, len(tasks))):
            pool.start(number)
        while pool.busy():
            pool.process_messages()
    finally:
        pool.stop()


@dataclass(slots=True)
class _Worker:
    number: int
    process: SpawnProcess
    pipe: Connection
    from_standby: bool
    ready: bool = False
    task: int | None = None


class _Pool:
    """Worker processes and their tasks; mutable."""

    def __init__(
        self,
        tasks: Sequence[Any],
        work: Work,
        on_event: Listener,
        logs: Path | None,
        standby: list[_Process],
    ) -> None:
        self._tasks = tasks
        self._work = work
        self._on_event = on_event
        self._logs = logs
        self._standby = standby
        self._workers: list[_Worker] = []
        self._queue = TaskQueue(len(tasks), on_event)
        self._failed_starts = 0  # consecutive workers that died during start-up

    def start(self, number: int) -> None:
        """Start a worker, in a standby process if one is left."""
        log = self._log(number)
        if self._standby:
            process, pipe = self._standby.pop(0)
            with suppress(OSError):  # a dead process is handled when its pipe is read
                pipe.send(Assignment(self._work, log))
            from_standby = True
        else:
            process, pipe = start_process(serve, self._work, log)
            from_standby = False
        self._workers.append(_Worker(number, process, pipe, from_standby))

    def stop(self) -> None:
        """Kill all workers."""
        _kill([(worker.process, worker.pipe) for worker in self._workers])
        self._workers.clear()

    def busy(self) -> bool:
        """Return whether a task is pending or running."""
        return bool(self._queue.pending) or any(worker.task is not None for worker in self._workers)

    def process_messages(self) -> None:
        """Wait until workers send messages, and handle one message of each."""
        readable = connection.wait([worker.pipe for worker in self._workers])
        for worker in [worker for worker in self._workers if worker.pipe in readable]:
            try:
                message: Message | None = worker.pipe.recv()
            except (EOFError, OSError):
                message = None
            if message is None:
                self._handle_death(worker)
            else:
                self._handle_message(worker, message)

    def _handle_message(self, worker: _Worker, message: Message) -> None:
        task = worker.task
        if isinstance(message, Ready):
            worker.ready = True
            self._failed_starts = 0
            self._assign_task(worker)
        elif isinstance(message, Progress) and task is not None:
            self._on_event(Progressed(worker.number, task, message.share))
        elif isinstance(message, TaskResult) and task is not None:
            worker.task = None
            self._on_event(Finished(worker.number, task, message.value))
            self._assign_task(worker)
        elif isinstance(message, Failed):
            if message.fatal:
                raise fatal_error(message, self._log(worker.number))
            self._count_failure(worker, message)
            self._replace(worker)  # the failure may have left the simulator in an invalid state

    def _assign_task(self, worker: _Worker) -> None:
        if not self._queue.pending:
            return
        worker.task = self._queue.pending.popleft()
        try:
            worker.pipe.send(self._tasks[worker.task])
        except OSError:
            return  # a dead worker is handled when its pipe is read
        self._on_event(Started(worker.number, worker.task))

    def _count_failure(self, worker: _Worker, failed: Failed) -> None:
        task, worker.task = worker.task, None
        if task is not None:
            self._queue.fail(worker.number, task, failed)

    def _handle_death(self, worker: _Worker) -> None:
        worker.process.join()
        failed = exit_failure(worker.process.exitcode or 0)
        if not worker.ready and not worker.from_standby:  # else a fresh worker shows the reason
            self._failed_starts += 1
            if self._failed_starts >= MAX_FAILED_STARTS:
                where = "" if self._logs is None else f" See {self._logs}."
                message = f"Worker processes do not start. {failed.reason}{where}"
                raise SimulationError(message)
        self._count_failure(worker, failed)
        self._replace(worker)

    def _log(self, number: int) -> Path | None:
        return None if self._logs is None else self._logs / log_name(number)

    def _replace(self, worker: _Worker) -> None:
        _kill([(worker.process, worker.pipe)])
        self._workers.remove(worker)
        if self._queue.pending:
            self.start(worker.number)
