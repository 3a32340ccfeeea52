"""Scores a planner on a suite: drives the episodes that have no record and writes the summary."""

import logging
import os
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from plant_bench.api.execution import chosen_executor, cores, isolation_for
from plant_bench.api.numbers import check_episodes
from plant_bench.api.planners import PlannerLike, resolve
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.run.episode_queue import SuiteEvent, run_suite
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.run_lock import Shard
from plant_bench.runner.run.score_run import Run as OpenRun
from plant_bench.runner.run.score_run import ScoreRequest, open_run
from plant_bench.runner.run.speed import read_timings
from plant_bench.runner.workers.executors import Executor, LocalExecutor
from plant_bench.runner.workers.isolation import Isolation, loader_of
from plant_bench.runner.workers.preloading import preloader
from plant_bench.runner.workers.worker import WORKER_EXITED
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.penalties import PenaltyScheme, penalty_scheme_of
from plant_bench.user_code import planner_log, with_log

if TYPE_CHECKING:  # loads pandas, which driving does not need
    from plant_bench.api.run import Run

Listener = Callable[[SuiteEvent], None]
RunMonitor = Callable[[OpenRun], AbstractContextManager[Listener]]
FAILURES = (Status.SIMULATION_CRASHED, Status.AGENT_CRASHED)

_log = logging.getLogger("plant_bench")


@dataclass(frozen=True)
class ExecutionSettings:
    """How a run is executed; its records do not depend on these settings.

    Attributes:
        workers: Number of processes on this machine.
        overwrite: Drive finished episodes again.
        recordings: Record every tick.
        penalties: Penalty scheme of the summary.
        executor: Where episodes are driven; None for new processes on this machine.
        shard: The part of the episodes to drive; None for all.
        isolation: How the planner is isolated; None if the workers load it themselves.
    """

    workers: int
    overwrite: bool = False
    recordings: bool = True
    penalties: PenaltyScheme = PenaltyScheme.LB1_0
    executor: Executor | None = None
    shard: Shard | None = None
    isolation: Isolation | None = None

    def __str__(self) -> str:
        return str(self.executor or LocalExecutor(self.workers))


@dataclass(frozen=True)
class Failure:
    """Episodes of a run that ended because the planner or the simulator crashed.

    Attributes:
        status: Their status, one of `FAILURES`.
        count: Number of these episodes.
        episodes: Number of all episodes of the run.
        route: Route of the first of these episodes.
        reason: Error message of the first of these episodes.
        log: File with the output of the worker that drove it; the folder of all logs if its worker
            has ended.
    """

    status: Status
    count: int
    episodes: int
    route: str
    reason: str
    log: Path

    def __str__(self) -> str:
        reason = self.reason
        if self.status is Status.AGENT_CRASHED and reason.startswith(WORKER_EXITED):
            reason += " If the planner ended it (os._exit), use --isolate."
        text = (
            f"{self.count} of {self.episodes} episodes ended with '{self.status.value}', the first "
            f"on {self.route}: {reason}"
        )
        return with_log(text, self.log)


def score(
    planner: PlannerLike,
    *,
    suite: str | os.PathLike[str] = "longest6",
    routes: str | None = None,
    repetitions: int = 3,
    seed: int = 0,
    density: str = "dense",
    hazards: bool = True,
    workers: int | None = None,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    recordings: bool = True,
    penalties: str = "lb1.0",
    isolate: bool = False,
    executor: str = "local",
    address: str | None = None,
    shard: str | None = None,
    on_event: Listener | None = None,
) -> "Run":
    """Drive the routes of a suite and return the run, as `plant-bench score` does.

    The same call again continues an interrupted run: only missing episodes are driven. An episode
    in which the planner or the simulator crashes is recorded and counts in all means; a warning is
    logged.

    Args:
        planner: A name of `plant-bench agents`, "module:Class", "file.py:Class" or
            "command:PROGRAM" (weights after an "@", as in "plant@models/mine"), a class, or an
            object. An object, or a class defined in a notebook, is pickled for the workers; each
            episode starts from a fresh copy.
        suite: A suite's name, or a folder or file of routes.
        routes: Numbers, ranges and ids, as in "0,3-5,town02-1". Default: all routes.
        repetitions: Number of episodes on each route.
        seed: Base seed of the traffic; use the same one for all planners to be compared.
        density: Traffic density.
        hazards: Whether the routes' hazards are enabled. Runs without hazards have another protocol
            and cannot be compared with runs that have them.
        workers: Number of processes; does not change the scores. Default: one per core.
        out: Folder of the run. Default: `reports/PLANNER-SUITE`.
        overwrite: Drive finished episodes again.
        recordings: Record every tick, for `Run.why`, rescoring and replays.
        penalties: Penalty scheme: "lb1.0", as in Longest6, or "lb2.1".
        isolate: Run the planner in a separate process, so that a hang, memory leak or crash ends
            only its own episode. A "command:PROGRAM" planner is always isolated.
        executor: "local" for processes on this machine, "ray" for a Ray cluster.
        address: Address of the Ray cluster, "HOST:6379" or "ray://HOST:10001". Default: the cluster
            that this machine is part of.
        shard: Part of the episodes to drive, as in "1/8", if several calls share a run.
        on_event: Called with each event of an episode: start, progress, end
            (`runner.run.episode_queue`).

    Raises:
        InputError: The request cannot be met, or the folder holds another run.
        SimulationError: Worker processes do not start.
    """
    from plant_bench.api.run import Run

    check_episodes(repetitions, seed, workers)
    resolved = resolve(planner)
    request = ScoreRequest(
        resolved.spec, os.fspath(suite), routes, repetitions, seed, density, hazards
    )
    folder = resolved.run_folder(request) if out is None else Path(out)
    settings = ExecutionSettings(
        cores() if workers is None else workers,
        executor=chosen_executor(executor, address, workers, _log.warning),
        shard=None if shard is None else Shard.parse(shard),
        overwrite=overwrite,
        recordings=recordings,
        penalties=penalty_scheme_of(penalties),
        isolation=isolation_for(
            resolved.spec, isolate=isolate, log=RunFolder(request.folder(folder)).planner_log
        ),
    )
    run = drive_missing(request, folder, settings, silent_monitor(on_event))
    for failure in failures_of(run):
        _log.warning("%s", failure)
    result = Run(run.folder.path, settings.penalties)
    if not run.unfinished_by_others():
        result.write_summary()
    return result


def drive_missing(
    request: ScoreRequest, out: Path | None, settings: ExecutionSettings, monitor: RunMonitor
) -> OpenRun:
    """Drive the episodes of a run that have no record.

    Args:
        request: Planner and episodes.
        out: Folder of the run; None for `reports/<run name>`.
        settings: How the run is executed.
        monitor: Returns, for the opened run, a context manager that yields the event listener.

    Raises:
        PlantBenchError: The run cannot start or continue.
        KeyboardInterrupt: Ctrl-C was pressed; finished episodes are kept and summarised.
    """
    with ExitStack() as hold:
        executor = settings.executor or LocalExecutor(
            settings.workers, preloader(request.agent, isolate=settings.isolation is not None)
        )
        hold.enter_context(executor.connected())  # before the run's folder is created
        load = loader_of(settings.isolation)  # this process loads planners, too
        with planner_log(RunFolder(request.folder(out)).planner_log):
            run = open_run(
                request,
                out,
                overwrite=settings.overwrite,
                shard=settings.shard,
                lock_stack=hold,
                load=load,
            )
        try:
            with monitor(run) as listener:
                run_suite(
                    run.missing,
                    run.folder,
                    workers=settings.workers,
                    recordings=settings.recordings,
                    on_event=listener,
                    executor=executor,
                    isolation=settings.isolation,
                )
        except KeyboardInterrupt:
            _summarise_finished(run, settings.penalties)
            raise
        run.remove_partial_files()
    return run


def failures_of(run: OpenRun) -> list[Failure]:
    """Return the crashes of a run: at most one `Failure` for each status in `FAILURES`."""
    results = {episode_name(job): run.folder.record(episode_name(job)) for job in run.jobs}
    failures = []
    for status in FAILURES:
        failed = [name for name, result in results.items() if result and result.status is status]
        first = results[failed[0]] if failed else None
        if first is not None:
            log = _log_of(run.folder, failed[0])
            failures.append(
                Failure(status, len(failed), len(run.jobs), first.route, first.reason, log)
            )
    return failures


def _log_of(folder: RunFolder, episode: str) -> Path:
    """Return the log of the worker that drove an episode; the folder of logs if it is unknown."""
    logs = folder.path / "logs"
    for timing in read_timings(folder, [episode]):
        if re.fullmatch(r"worker\d+\.log", timing.log) and (logs / timing.log).is_file():
            return logs / timing.log
    return logs


def silent_monitor(on_event: Listener | None = None) -> RunMonitor:
    """Return a monitor that prints nothing and passes events to `on_event`, if given."""

    @contextmanager
    def monitor(run: OpenRun) -> Iterator[Listener]:
        for note in run.notes:
            _log.info("%s", note)
        yield on_event or _ignore

    return monitor


def _ignore(event: SuiteEvent) -> None:
    del event


def _summarise_finished(run: OpenRun, penalties: PenaltyScheme) -> None:
    """Write the summary of an interrupted run's finished episodes."""
    from plant_bench.runner.run.summary_files import write_summary

    run.remove_partial_files()
    left = run.unfinished()
    if left < len(run.jobs) and not run.others:
        write_summary(run.folder, missing=left, penalties=penalties)
