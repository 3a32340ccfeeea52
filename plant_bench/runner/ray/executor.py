"""Runs tasks on a Ray cluster, with the same events and results as local processes.

Each worker is an actor on a fixed node that supervises one process (`runner.ray.node`). A failure
in that process counts as in a local run. A lost actor does not count as a failure of its task: the
task runs again on another node. Only this process writes into the run's folder.
"""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.ray.cluster import connection_to
from plant_bench.runner.ray.node import ActorReply, NodeWorker, Refusal, TaskOutput
from plant_bench.runner.ray.payload import Payload, pack
from plant_bench.runner.workers.executors import (
    Finished,
    Listener,
    Progressed,
    SaveFile,
    Started,
    TaskQueue,
    fatal_error,
    log_name,
)
from plant_bench.runner.workers.worker import Failed, Message, Progress, Ready, TaskResult, Work

MAX_LOST_WORKERS = 10  # a task that has lost its worker this often is left for another run
MAX_FAILED_STARTS = 3  # workers lost during start-up before their node is excluded
POLL_INTERVAL = 2.0  # s between two searches for new nodes
NO_NODE_TIMEOUT = 60.0  # s that a run waits for a node when none is left
CLEANUP_TIMEOUT = 3.0  # s for actors to remove their folders

OnMessage = Callable[[str], None]


@dataclass(frozen=True)
class RayExecutor:
    """Runs tasks on the nodes of a Ray cluster.

    Attributes:
        address: "auto", "HOST:PORT" of a cluster this machine is part of, or "ray://HOST:PORT".
        workers: Maximum number of workers; None for one per CPU of the cluster.
        on_message: Called with one line for the user for each excluded node and lost worker.
    """

    address: str = "auto"
    workers: int | None = None
    on_message: OnMessage = print

    def __str__(self) -> str:
        count = "all CPUs" if self.workers is None else f"{self.workers} workers"
        return f"{count} of the Ray cluster at {self.address}"

    def connected(self) -> AbstractContextManager[None]:
        """Connect to the cluster; see `Executor`.

        Raises:
            InputError: The cluster does not respond.
        """
        return connection_to(self.address)

    def run_tasks(
        self,
        tasks: Sequence[Any],
        work: Work,
        *,
        on_event: Listener,
        logs: Path,
        save_file: SaveFile,
    ) -> None:
        """Run all tasks; see `Executor`.

        Raises:
            InputError: The cluster does not respond, or all nodes are excluded.
            SimulationError: No node is left, or tasks have lost their workers too often.
        """
        if not tasks:
            return
        payload = pack(tasks)
        with self.connected():
            pool = _RayPool(self, tasks, work, payload, on_event, logs, save_file)
            try:
                while pool.busy():
                    pool.process_replies()
            finally:
                pool.stop()
        pool.check_complete()


@dataclass(slots=True)
class _RemoteWorker:
    number: int
    actor: Any
    node: str
    name: str  # of the node, as shown to the user
    reply: Any  # reference to the result of the current call
    task: int | None = None
    ready: bool = False


class _RayPool:
    """Actors on the nodes of a cluster, and their tasks; mutable."""

    def __init__(
        self,
        settings: RayExecutor,
        tasks: Sequence[Any],
        work: Work,
        payload: Payload,
        on_event: Listener,
        logs: Path,
        save_file: SaveFile,
    ) -> None:
        import ray

        self._ray = ray
        self._settings, self._tasks, self._work = settings, tasks, work
        self._on_event, self._logs, self._save_file = on_event, logs, save_file
        self._payload = ray.put(payload)
        self._queue = TaskQueue(len(tasks), on_event)
        self._workers: list[_RemoteWorker] = []
        self._excluded: dict[str, str] = {}  # reason by node
        self._lost_workers: Counter[int] = Counter()
        self._failed_starts: Counter[str] = Counter()  # by node
        self._dropped_tasks: list[int] = []
        self._cleanups: list[Any] = []
        self._last_search = -POLL_INTERVAL
        self._no_node_since: float | None = None

    def busy(self) -> bool:
        """Return whether a task is pending or running."""
        return bool(self._queue.pending) or any(one.task is not None for one in self._workers)

    def process_replies(self) -> None:
        """Wait until workers reply, and handle one reply; start workers on new nodes."""
        if time.monotonic() - self._last_search >= POLL_INTERVAL:
            self._last_search = time.monotonic()
            self._add_workers()
        replies = {one.reply: one for one in self._workers if one.reply is not None}
        if not replies:
            time.sleep(POLL_INTERVAL)
            return
        ready, _ = self._ray.wait(list(replies), num_returns=1, timeout=POLL_INTERVAL)
        for reply in ready:
            self._receive(replies[reply])

    def stop(self) -> None:
        """Kill all workers, after a short time to clean up."""
        try:
            calls = self._cleanups + [one.actor.close.remote() for one in self._workers]
            if calls:
                self._ray.wait(calls, num_returns=len(calls), timeout=CLEANUP_TIMEOUT)
        finally:
            for one in self._workers:
                self._ray.kill(one.actor)

    def check_complete(self) -> None:
        """Check that no task was dropped.

        Raises:
            SimulationError: Tasks were dropped.
        """
        if self._dropped_tasks:
            message = (
                f"{len(self._dropped_tasks)} episodes lost their node {MAX_LOST_WORKERS} times "
                "each and were not run. The others are saved; repeat the command to run these."
            )
            raise SimulationError(message)

    def _add_workers(self) -> None:
        """Start workers on free CPUs, spread evenly over the nodes."""
        nodes = {node["NodeID"]: node for node in self._ray.nodes() if node["Alive"]}
        free_cpus = {
            name: int(node["Resources"].get("CPU", 0)) - self._workers_on(name)
            for name, node in nodes.items()
            if name not in self._excluded
        }
        self._check_any_left(nodes, free_cpus)
        needed = len(self._queue.pending) - sum(one.task is None for one in self._workers)
        if self._settings.workers is not None:
            needed = min(needed, self._settings.workers - len(self._workers))
        slots = [
            (turn, name) for name, count in free_cpus.items() for turn in range(count) if count > 0
        ]
        for _, name in sorted(slots)[: max(needed, 0)]:
            self._start_worker(name, _name_of(nodes[name]))

    def _workers_on(self, name: str) -> int:
        return sum(one.node == name for one in self._workers)

    def _check_any_left(self, nodes: dict[str, Any], free_cpus: dict[str, int]) -> None:
        if self._workers or any(count > 0 for count in free_cpus.values()):
            self._no_node_since = None
            return
        if self._excluded:
            reasons = sorted(set(self._excluded.values()))
            message = f"All nodes of the Ray cluster are excluded: {' | '.join(reasons)}"
            raise InputError(message)
        now = time.monotonic()
        self._no_node_since = now if self._no_node_since is None else self._no_node_since
        if now - self._no_node_since >= NO_NODE_TIMEOUT:
            message = (
                f"The Ray cluster has had no CPU for {NO_NODE_TIMEOUT:.0f} s ({len(nodes)} nodes). "
                "Finished episodes are saved; repeat the command to run the others."
            )
            raise SimulationError(message)

    def _start_worker(self, node: str, name: str) -> None:
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        taken = {one.number for one in self._workers}
        number = next(number for number in range(len(taken) + 1) if number not in taken)
        remote: Any = self._ray.remote(NodeWorker)
        strategy = NodeAffinitySchedulingStrategy(node, soft=False)
        actor = remote.options(num_cpus=1, max_restarts=0, scheduling_strategy=strategy).remote()
        reply = actor.start.remote(self._payload, self._work)
        self._workers.append(_RemoteWorker(number, actor, node, f"{name} ({node[:8]})", reply))

    def _receive(self, one: _RemoteWorker) -> None:
        """Handle a worker's reply, and call it again."""
        from ray.exceptions import RayError, RayTaskError

        try:
            reply: ActorReply = self._ray.get(one.reply)
        except RayTaskError as error:
            self._exclude_node(one, _last_line(error.cause or error))
            return
        except RayError as error:
            self._handle_loss(one, _last_line(error))
            return
        if reply.output:
            with (self._logs / log_name(one.number)).open("ab") as log:
                log.write(reply.output)
        self._handle_message(one, reply.message)

    def _handle_message(self, one: _RemoteWorker, message: Message | Refusal | None) -> None:
        task = one.task
        if isinstance(message, Refusal):
            self._exclude_node(one, message.reason)
            return
        if isinstance(message, Progress) and task is not None:
            self._on_event(Progressed(one.number, task, message.share))
        elif isinstance(message, TaskResult) and task is not None:
            output: TaskOutput = message.value
            for name, content in output.files.items():
                self._save_file(name, content)
            one.task = None
            self._on_event(Finished(one.number, task, output.value))
        elif isinstance(message, Failed):
            if message.fatal:
                raise fatal_error(message, self._logs / log_name(one.number))
            one.task = None
            if task is not None:
                self._queue.fail(one.number, task, message)
        one.ready = one.ready or isinstance(message, Ready)
        self._call_again(one)

    def _call_again(self, one: _RemoteWorker) -> None:
        """Query the progress of a worker's task, or send it its next task."""
        if one.task is not None:
            one.reply = one.actor.step.remote(None)
        elif self._queue.pending:
            one.task = self._queue.pending.popleft()
            one.reply = one.actor.step.remote(self._tasks[one.task])
            self._on_event(Started(one.number, one.task))
        else:
            self._release(one)

    def _release(self, one: _RemoteWorker) -> None:
        self._workers.remove(one)
        self._cleanups.append(one.actor.close.remote())
        one.actor.__ray_terminate__.remote()

    def _exclude_node(self, one: _RemoteWorker, reason: str) -> None:
        """Use a node no more, since its results could differ or workers do not start there."""
        if one.node not in self._excluded:
            self._excluded[one.node] = f"{one.name}: {reason}"
            self._settings.on_message(f"Node {one.name} is excluded: {reason}")
        self._remove(one)

    def _handle_loss(self, one: _RemoteWorker, reason: str) -> None:
        """Remove a lost worker and requeue its task, without counting a failure of the task."""
        if not one.ready:
            self._failed_starts[one.node] += 1
            if self._failed_starts[one.node] >= MAX_FAILED_STARTS:
                self._exclude_node(one, reason)
                return
        if one.task is not None:
            self._lost_workers[one.task] += 1
            self._settings.on_message(
                f"A worker on node {one.name} was lost; its episode is run again."
            )
        self._remove(one)

    def _remove(self, one: _RemoteWorker) -> None:
        """Remove a worker; requeue its task unless it has lost too many workers."""
        self._workers.remove(one)
        if one.task is not None and self._lost_workers[one.task] >= MAX_LOST_WORKERS:
            self._dropped_tasks.append(one.task)
        elif one.task is not None:
            self._queue.pending.appendleft(one.task)
        self._ray.kill(one.actor)


def _last_line(error: Exception) -> str:
    return (str(error).strip() or type(error).__name__).splitlines()[-1].strip()


def _name_of(node: dict[str, Any]) -> str:
    return node.get("NodeManagerHostname") or node.get("NodeManagerAddress") or "unnamed"
