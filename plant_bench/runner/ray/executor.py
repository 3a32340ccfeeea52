"""Runs tasks on a Ray cluster, with the same events and results as local processes.

Each worker is an actor bound to a node that supervises one process (`runner.ray.node`). A failure
in that process counts as it does locally. A lost actor is not a failure of its task: the task runs
again elsewhere. Only this process writes into the run's folder.
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
from plant_bench.runner.ray.node import Brought, Cannot, News, NodeWorker
from plant_bench.runner.ray.payload import Payload, pack
from plant_bench.runner.workers.executors import (
    Agenda,
    Finished,
    Keep,
    Listener,
    Progressed,
    Started,
)
from plant_bench.runner.workers.worker import Done, Failed, Ready, Share, Work

LOSSES = 10  # a task that has lost its worker this often is left for another run
STARTS = 3  # workers that are lost in a row before they are ready: their node takes no part
LOOK = 2.0  # s between two looks for nodes that have come
ALONE = 60.0  # s that a run waits for nodes when there is none left
FAREWELL = 3.0  # s that actors are given to tidy up

Say = Callable[[str], None]


@dataclass(frozen=True)
class RayExecutor:
    """Runs tasks on the nodes of a Ray cluster.

    Attributes:
        address: "auto", "HOST:PORT" of a cluster this machine is part of, or "ray://HOST:PORT".
        workers: The most that work at a time; None for one on each CPU of the cluster.
        say: Told in one line what the user should know: nodes refused and lost.
    """

    address: str = "auto"
    workers: int | None = None
    say: Say = print

    def __str__(self) -> str:
        most = "all CPUs" if self.workers is None else f"{self.workers} workers"
        return f"{most} of the Ray cluster at {self.address}"

    def connected(self) -> AbstractContextManager[None]:
        """Be connected to the cluster; see `Executor`.

        Raises:
            InputError: It is not there.
        """
        return connection_to(self.address)

    def run_tasks(
        self, tasks: Sequence[Any], work: Work, *, on_event: Listener, logs: Path, keep: Keep
    ) -> None:
        """Run all tasks; see `Executor`.

        Raises:
            InputError: The cluster is not there, or no node of it gives equal results.
            SimulationError: There is no node left, or tasks have lost theirs too often.
        """
        if not tasks:
            return
        payload = pack(tasks)
        with self.connected():
            pool = _RayPool(self, tasks, work, payload, on_event, logs, keep)
            try:
                while pool.busy():
                    pool.listen()
            finally:
                pool.stop()
        pool.check_complete()


@dataclass(slots=True)
class _Remote:
    number: int
    actor: Any
    node: str
    name: str  # of the node, for people
    answer: Any  # the call that is under way
    task: int | None = None
    ready: bool = False


class _RayPool:
    """Actors on the nodes of a cluster, and what they have to do; mutable."""

    def __init__(
        self,
        settings: RayExecutor,
        tasks: Sequence[Any],
        work: Work,
        payload: Payload,
        on_event: Listener,
        logs: Path,
        keep: Keep,
    ) -> None:
        import ray

        self._ray = ray
        self._settings, self._tasks, self._work = settings, tasks, work
        self._on_event, self._logs, self._keep = on_event, logs, keep
        self._payload = ray.put(payload)
        self._agenda = Agenda(len(tasks), on_event)
        self._workers: list[_Remote] = []
        self._refused: dict[str, str] = {}  # why, by node
        self._losses: Counter[int] = Counter()
        self._stillborn: Counter[str] = Counter()  # workers lost before they were ready, by node
        self._left: list[int] = []
        self._farewells: list[Any] = []
        self._looked = -LOOK
        self._alone_since: float | None = None

    def busy(self) -> bool:
        """Tell whether a task waits or is worked on."""
        return bool(self._agenda.waiting) or any(one.task is not None for one in self._workers)

    def listen(self) -> None:
        """Wait until workers say something, and answer them; take in nodes that have come."""
        if time.monotonic() - self._looked >= LOOK:
            self._looked = time.monotonic()
            self._grow()
        answers = {one.answer: one for one in self._workers if one.answer is not None}
        if not answers:
            time.sleep(LOOK)
            return
        ready, _ = self._ray.wait(list(answers), num_returns=1, timeout=LOOK)
        for answer in ready:
            self._take(answers[answer])

    def stop(self) -> None:
        """End all workers, whatever they do."""
        try:
            said = self._farewells + [one.actor.close.remote() for one in self._workers]
            if said:
                self._ray.wait(said, num_returns=len(said), timeout=FAREWELL)
        finally:
            for one in self._workers:
                self._ray.kill(one.actor)

    def check_complete(self) -> None:
        """Say which tasks were left.

        Raises:
            SimulationError: Some were.
        """
        if self._left:
            message = (
                f"{len(self._left)} episodes lost their node {LOSSES} times each and are left. "
                "The others are kept; the same command again runs these."
            )
            raise SimulationError(message)

    def _grow(self) -> None:
        """Put workers on the nodes that have room for them, one a node and round."""
        nodes = {node["NodeID"]: node for node in self._ray.nodes() if node["Alive"]}
        room = {
            name: int(node["Resources"].get("CPU", 0)) - self._on(name)
            for name, node in nodes.items()
            if name not in self._refused
        }
        self._check_any_left(nodes, room)
        wanted = len(self._agenda.waiting) - sum(one.task is None for one in self._workers)
        if self._settings.workers is not None:
            wanted = min(wanted, self._settings.workers - len(self._workers))
        places = [
            (turn, name) for name, number in room.items() for turn in range(number) if number > 0
        ]
        for _, name in sorted(places)[: max(wanted, 0)]:
            self._hire(name, _name_of(nodes[name]))

    def _on(self, name: str) -> int:
        return sum(one.node == name for one in self._workers)

    def _check_any_left(self, nodes: dict[str, Any], room: dict[str, int]) -> None:
        if self._workers or any(number > 0 for number in room.values()):
            self._alone_since = None
            return
        if self._refused:
            reasons = sorted(set(self._refused.values()))
            message = f"No node of the Ray cluster can take part: {' | '.join(reasons)}"
            raise InputError(message)
        now = time.monotonic()
        self._alone_since = now if self._alone_since is None else self._alone_since
        if now - self._alone_since >= ALONE:
            message = (
                f"The Ray cluster has had no CPU for {ALONE:.0f} s ({len(nodes)} nodes). Finished "
                "episodes are kept; the same command again runs the others."
            )
            raise SimulationError(message)

    def _hire(self, node: str, name: str) -> None:
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        taken = {one.number for one in self._workers}
        number = next(number for number in range(len(taken) + 1) if number not in taken)
        remote: Any = self._ray.remote(NodeWorker)
        strategy = NodeAffinitySchedulingStrategy(node, soft=False)
        actor = remote.options(num_cpus=1, max_restarts=0, scheduling_strategy=strategy).remote()
        answer = actor.start.remote(self._payload, self._work)
        self._workers.append(_Remote(number, actor, node, f"{name} ({node[:8]})", answer))

    def _take(self, one: _Remote) -> None:
        """Hear what a worker has said, and ask it for more."""
        from ray.exceptions import RayError, RayTaskError

        try:
            news: News = self._ray.get(one.answer)
        except RayTaskError as error:
            self._refuse(one, _last_line(error.cause or error))
            return
        except RayError as error:
            self._lose(one, _last_line(error))
            return
        if news.printed:
            with (self._logs / f"worker{one.number}.log").open("ab") as log:
                log.write(news.printed)
        self._hear(one, news)

    def _hear(self, one: _Remote, news: News) -> None:
        message, task = news.message, one.task
        if isinstance(message, Cannot):
            self._refuse(one, message.reason)
            return
        if isinstance(message, Share) and task is not None:
            self._on_event(Progressed(one.number, task, message.share))
        elif isinstance(message, Done) and task is not None:
            brought: Brought = message.value
            for name, content in brought.files.items():
                self._keep(name, content)
            one.task = None
            self._on_event(Finished(one.number, task, brought.value))
        elif isinstance(message, Failed):
            if message.fatal:
                raise InputError(message.reason)
            one.task = None
            if task is not None:
                self._agenda.fail(one.number, task, message.reason)
        one.ready = one.ready or isinstance(message, Ready)
        self._ask(one)

    def _ask(self, one: _Remote) -> None:
        """Give a worker its next task, or ask how it goes on with the one it has."""
        if one.task is not None:
            one.answer = one.actor.step.remote(None)
        elif self._agenda.waiting:
            one.task = self._agenda.waiting.popleft()
            one.answer = one.actor.step.remote(self._tasks[one.task])
            self._on_event(Started(one.number, one.task))
        else:
            self._dismiss(one)

    def _dismiss(self, one: _Remote) -> None:
        self._workers.remove(one)
        self._farewells.append(one.actor.close.remote())
        one.actor.__ray_terminate__.remote()

    def _refuse(self, one: _Remote, reason: str) -> None:
        """Take nothing more from a node whose results could differ."""
        if one.node not in self._refused:
            self._refused[one.node] = f"{one.name}: {reason}"
            self._settings.say(f"Node {one.name} takes no part: {reason}")
        self._drop(one)

    def _lose(self, one: _Remote, reason: str) -> None:
        """Let a task whose worker is gone run again elsewhere: it is not the task's fault."""
        if not one.ready:
            self._stillborn[one.node] += 1
            if self._stillborn[one.node] >= STARTS:
                self._refuse(one, reason)
                return
        if one.task is not None:
            self._losses[one.task] += 1
            self._settings.say(f"A worker on node {one.name} is lost; its episode runs elsewhere.")
        self._drop(one)

    def _drop(self, one: _Remote) -> None:
        """Do without a worker; its task waits again, if it has not been lost too often."""
        self._workers.remove(one)
        if one.task is not None and self._losses[one.task] >= LOSSES:
            self._left.append(one.task)
        elif one.task is not None:
            self._agenda.waiting.appendleft(one.task)
        self._ray.kill(one.actor)


def _last_line(error: Exception) -> str:
    return (str(error).strip() or type(error).__name__).splitlines()[-1].strip()


def _name_of(node: dict[str, Any]) -> str:
    return node.get("NodeManagerHostname") or node.get("NodeManagerAddress") or "unnamed"
