"""Benchmark: cost per worker process, interference between workers, and Ray's overhead.

    python benchmarks/scaling.py --agent expert --workers 1 2 --repeat 3
    PYTHONPATH=benchmarks ray start --head --num-cpus 2
    python benchmarks/scaling.py --agent plant --workers 1 2 --ray auto

Times are medians over the repetitions, of processor time where possible, which depends little on
other load. Ray's overhead is measured with tasks that only return as much data as an episode, on a
running cluster that can import this file.
"""

import argparse
import resource
import statistics
import tempfile
import time
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.runner.episode.jobs import make_jobs
from plant_bench.runner.ray.payload import NodePaths, Requirements
from plant_bench.runner.run.episode_queue import _run_task, _Task
from plant_bench.runner.workers.executors import Event, Executor, Finished, LocalExecutor, Started
from plant_bench.runner.workers.worker import Report
from plant_bench.world.route import load_suite

EPISODE = 1_060_000  # bytes: mean size of record and recording of PlanT on longest6
EMPTY_TASKS = 30


@dataclass(frozen=True)
class Cost:
    """Cost of one task in its worker."""

    processor_s: float
    wall_s: float
    rss_mb: float


@dataclass(frozen=True)
class EmptyTask:
    """A task that only writes a file as large as an episode's."""

    output: Path
    requirements: Requirements = field(default_factory=Requirements)

    def with_paths(self, paths: NodePaths) -> "EmptyTask":
        """Return the task with the paths of another machine."""
        return EmptyTask(paths.output)


def write_output(task: EmptyTask, _report: Report) -> None:
    """Write as much data as an episode."""
    (task.output / "recordings").mkdir(parents=True, exist_ok=True)
    (task.output / "recordings" / "a.parquet").write_bytes(bytes(EPISODE))


def measured(task: _Task, report: Report) -> Cost:
    """Drive an episode and return its cost."""
    processor, wall = time.process_time(), time.perf_counter()
    _run_task(task, report)
    rss = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Cost(time.process_time() - processor, time.perf_counter() - wall, rss)


def tasks_of(agent: str, routes: str, folder: Path, count: int) -> list[_Task]:
    """Return the tasks: each episode `count` times, once per worker."""
    chosen = [route for route in load_suite("longest6") if route.id in routes.split(",")]
    checksum = agent_checksum(agent)
    jobs = make_jobs(agent, checksum, chosen, repetitions=1, seed=0, density="dense")
    return [
        _Task(
            job,
            folder / f"{number}-{job.route.id}.parquet",
            "plant_bench.runner.episode.loop:run_episode",
        )
        for job in jobs
        for number in range(count)
    ]


def time_start_up(repeat: int, folder: Path) -> None:
    """Print the time from the start of a worker to its first task."""
    spent, processor = [], []
    for _ in range(repeat):
        begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        at: list[float] = []

        def listen(event: Event, at: list[float] = at) -> None:
            if isinstance(event, Started):
                at.append(time.perf_counter())

        LocalExecutor(1).run_tasks(
            [EmptyTask(folder)],
            write_output,
            on_event=listen,
            logs=folder,
            save_file=lambda *_: None,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent.append(at[0] - begin)
        processor.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    print(
        f"start of a worker: {statistics.median(spent):.2f} s of wall time, "
        f"{statistics.median(processor):.2f} s of processor time (median of {repeat})"
    )


def drive(agent: str, routes: str, workers: int, folder: Path) -> list[Cost]:
    """Return the costs of episodes with a number of workers at once."""
    costs: list[Cost] = []

    def listen(event: Event) -> None:
        if isinstance(event, Finished):
            costs.append(event.value)

    tasks = tasks_of(agent, routes, folder, workers)
    LocalExecutor(workers).run_tasks(
        tasks, measured, on_event=listen, logs=folder, save_file=lambda *_: None
    )
    return costs


def time_workers(agent: str, routes: str, workers: list[int], repeat: int, folder: Path) -> None:
    """Print the cost of an episode by number of workers."""
    found: dict[int, list[Cost]] = {count: [] for count in workers}
    for _ in range(repeat):
        for count in workers:  # in turn, so that other load affects all of them equally
            found[count] += drive(agent, routes, count, folder)
    base = statistics.median(cost.processor_s for cost in found[workers[0]])
    print(f"{agent} on {routes}: workers, processor s an episode, ratio, wall s, peak MB a worker")
    for count, costs in found.items():
        processor = statistics.median(cost.processor_s for cost in costs)
        wall = statistics.median(cost.wall_s for cost in costs)
        peak = max(cost.rss_mb for cost in costs)
        print(f"{count:3d} {processor:8.2f} {processor / base:6.2f} {wall:8.2f} {peak:6.0f}")


def time_empty_tasks(executor: Executor, folder: Path) -> tuple[float, float]:
    """Return wall time and this process's processor time per empty task, milliseconds."""
    at: list[float] = []

    def listen(event: Event) -> None:
        if isinstance(event, Finished):
            at.append(time.perf_counter())

    def save_file(name: str, content: bytes) -> None:
        (folder / Path(name).name).write_bytes(content)

    processor = time.process_time()
    executor.run_tasks(
        [EmptyTask(folder)] * EMPTY_TASKS,
        write_output,
        on_event=listen,
        logs=folder,
        save_file=save_file,
    )
    own = 1000.0 * (time.process_time() - processor) / EMPTY_TASKS
    return 1000.0 * statistics.median(b - a for a, b in pairwise(at)), own


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--agent", default="expert")
    parser.add_argument("--routes", default="town01-3,town03-1", help="ids, separated by commas")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--ray", help="address of a running Ray cluster")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        time_start_up(arguments.repeat, folder)
        time_workers(arguments.agent, arguments.routes, arguments.workers, arguments.repeat, folder)
        if arguments.ray:
            from plant_bench.runner.ray.executor import RayExecutor

            for label, executor in (
                ("here", LocalExecutor(1)),
                ("on Ray", RayExecutor(arguments.ray, 1)),
            ):
                wall, own = time_empty_tasks(executor, folder)
                print(
                    f"a task of {EPISODE / 1e6:.2f} MB {label}: {wall:.0f} ms, of which {own:.0f} "
                    "ms of processor time in the command itself"
                )


if __name__ == "__main__":
    from scaling import main as importable  # workers find its tasks by the module's name

    importable()
