"""Runs the episodes of a suite on worker processes and writes each record when it ends."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

from plant_bench.agents.loading.registry import Loader, load_agent
from plant_bench.runner.episode.jobs import Job, episode_name
from plant_bench.runner.episode.outcome import Outcome
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.ray.payload import NodePaths, Requirements
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.workers.executors import (
    Event,
    Executor,
    Finished,
    LocalExecutor,
    Lost,
    Progressed,
    Retried,
    Started,
    log_name,
)
from plant_bench.runner.workers.isolation import Isolation, episode_loader, loader_of
from plant_bench.runner.workers.worker import Report
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.user_code import contained

RUN_EPISODE = "plant_bench.runner.episode.loop:run_episode"


@dataclass(frozen=True)
class EpisodeStarted:
    """A worker has begun a job."""

    worker: int
    job: Job


@dataclass(frozen=True)
class EpisodeProgressed:
    """Progress of a worker's job, 0 to 1."""

    worker: int
    job: Job
    share: float


@dataclass(frozen=True)
class EpisodeRetried:
    """A job failed through no fault of the agent and will be retried."""

    worker: int
    job: Job
    reason: str


@dataclass(frozen=True)
class EpisodeEnded:
    """A job's record is on disk; no timing if the simulation crashed."""

    worker: int
    job: Job
    result: EpisodeResult
    timing: Timing | None


SuiteEvent = EpisodeStarted | EpisodeProgressed | EpisodeRetried | EpisodeEnded


@dataclass(frozen=True)
class _Task:
    """A job as it is sent to a worker."""

    job: Job
    recording: Path | None
    run_episode: str
    isolation: Isolation | None = None

    @property
    def requirements(self) -> Requirements:
        """Files that the task requires on another machine."""
        return Requirements(
            frozenset({self.job.agent}), frozenset({self.job.route.town_dir}), self.isolation
        )

    def with_paths(self, paths: NodePaths) -> "_Task":
        """Return the same task with the paths of another machine."""
        recording = self.recording and paths.output / "recordings" / self.recording.name
        planner = paths.planner(self.job.agent)
        job = replace(
            self.job,
            route=replace(self.job.route, town_folders=paths.town_folders),
            planner="" if planner == self.job.agent else planner,
        )
        isolation = self.isolation and self.isolation.for_other_machine()
        return replace(self, job=job, recording=recording, isolation=isolation)


def run_suite(
    jobs: Sequence[Job],
    folder: RunFolder,
    *,
    workers: int,
    recordings: bool = True,
    on_event: Callable[[SuiteEvent], None],
    run_episode: str = RUN_EPISODE,
    executor: Executor | None = None,
    isolation: Isolation | None = None,
) -> None:
    """Run jobs and write each record when its episode ends.

    A job whose worker dies or whose simulator fails is retried once and then recorded as
    "Failed - Simulation crashed", so that it counts in every mean; "Failed - Agent crashed" if its
    worker ended with an exit code, since only the planner's code can end the process in this way.

    Args:
        jobs: Jobs to run; existing records are replaced.
        folder: Folder of the run.
        workers: Number of processes on this machine, without an executor.
        recordings: Also record every tick.
        on_event: Called in this process with each event.
        run_episode: "module:function" that runs a job.
        executor: Runs the jobs, with its own number of workers.
        isolation: Runs the planner in a separate process; None to load it in the workers.

    Raises:
        InputError: An input that all episodes need is missing, or the folder is not writable.
        SimulationError: Worker processes do not start.
    """
    tasks = [
        _Task(
            job,
            folder.recording_path(episode_name(job)).absolute() if recordings else None,
            run_episode,
            isolation,
        )
        for job in jobs
    ]

    def listen(event: Event) -> None:
        job = jobs[event.task]
        match event:
            case Started():
                on_event(EpisodeStarted(event.worker, job))
            case Progressed():
                on_event(EpisodeProgressed(event.worker, job, event.share))
            case Retried():
                on_event(EpisodeRetried(event.worker, job, event.reason))
            case Finished():
                timing = event.value.timing.model_copy(update={"log": log_name(event.worker)})
                _end(event.worker, job, event.value.result, timing)
            case Lost():
                status = Status.AGENT_CRASHED if event.exited else Status.SIMULATION_CRASHED
                load = loader_of(isolation)
                _end(event.worker, job, crashed_result(job, event.reason, load, status), None)

    def _end(worker: int, job: Job, result: EpisodeResult, timing: Timing | None) -> None:
        folder.save(episode_name(job), result, timing)
        on_event(EpisodeEnded(worker, job, result, timing))

    executor = LocalExecutor(workers) if executor is None else executor
    logs = folder.path / "logs"
    executor.run_tasks(tasks, _run_task, on_event=listen, logs=logs, save_file=folder.write_bytes)


def _run_task(task: _Task, report: Report) -> Outcome:
    """Run an episode in a worker process."""
    module, _, function = task.run_episode.partition(":")
    run_episode = getattr(import_module(module), function)
    load = episode_loader(task.isolation)
    outcome = run_episode(task.job, recording=task.recording, progress=report, load=load)
    if outcome.result.status is Status.AGENT_CRASHED:  # below its traceback in the worker's log
        sys.stderr.write(f"{episode_name(task.job)}: {outcome.result.reason}\n")
    return outcome


def crashed_result(
    job: Job,
    reason: str,
    load: Loader = load_agent,
    status: Status = Status.SIMULATION_CRASHED,
) -> EpisodeResult:
    """Return the record of an episode whose worker or simulation crashed."""
    with contained():
        header = job.header(load(job.agent).inputs)
    return EpisodeResult(
        **header.model_dump(),
        status=status,
        reason=reason,
        route_length=job.route.length,
        completion=0.0,
        distance=0.0,
        duration=0.0,
    )
