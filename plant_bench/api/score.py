"""Scoring a planner: drive what of a run is missing, and sum up all there is."""

import logging
import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from plant_bench.api.execution import chosen_executor, cores, isolation_for
from plant_bench.api.planners import PlannerLike, resolve
from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.run.episode_queue import SuiteEvent, run_suite
from plant_bench.runner.run.run_lock import Shard
from plant_bench.runner.run.score_run import Run as OpenRun
from plant_bench.runner.run.score_run import ScoreRequest, open_run
from plant_bench.runner.workers.executors import Executor, LocalExecutor
from plant_bench.runner.workers.isolation import Isolation, loader_of
from plant_bench.runner.workers.preloading import preloader
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.penalties import PenaltyScheme, penalty_scheme_of

if TYPE_CHECKING:  # summaries are of pandas, which a run that is only driven does not need
    from plant_bench.api.run import Run

Listener = Callable[[SuiteEvent], None]
RunMonitor = Callable[[OpenRun], AbstractContextManager[Listener]]
FAILURES = (Status.SIMULATION_CRASHED, Status.AGENT_CRASHED)

_log = logging.getLogger("plant_bench")


@dataclass(frozen=True)
class Driving:
    """How a run is driven; its records do not depend on it.

    Attributes:
        workers: Processes, of this machine.
        overwrite: Drive again what is finished.
        recordings: Keep every tick.
        penalties: By which infractions become scores, in the summary.
        executor: Who drives; None for processes of this machine that begin now.
        shard: The part that is driven here; None for all of it.
        isolation: Keeps the planner in a process of its own; None where the workers load it.
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
    """Episodes of a run that ended for another reason than driving.

    Attributes:
        status: How they ended: one of `FAILURES`.
        count: How many.
        episodes: Of so many.
        route: Of the first of them.
        reason: What the planner or the simulator said in it.
    """

    status: Status
    count: int
    episodes: int
    route: str
    reason: str

    def __str__(self) -> str:
        return (
            f"{self.count} of {self.episodes} episodes ended with '{self.status.value}', the first "
            f"on {self.route}: {self.reason}"
        )


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
    """Drive a suite and return how well, as `plant-bench score` does.

    The same call again drives only what is missing, so that it may be interrupted at any time. An
    episode that crashes is recorded and stays in every mean; a warning is logged.

    Args:
        planner: A name of `plant-bench agents`, "module:Class", "file.py:Class" or
            "command:PROGRAM" (weights after an "@", as in "plant@models/mine"), a class, or an
            object. An object and a class of a notebook are handed to the workers as they are now;
            each episode starts from a fresh copy.
        suite: A suite's name, or a folder or file of routes.
        routes: Numbers, ranges and ids, as in "0,3-5,town02-1"; all without it.
        repetitions: Episodes on each route.
        seed: Base seed of the traffic; equal for all planners that are to be compared.
        density: Of the traffic.
        hazards: Whether the routes' hazards are played; without them it is another protocol.
        workers: Processes; one a core without it. Scores do not depend on it.
        out: The run's folder; `reports/PLANNER-SUITE` without it.
        overwrite: Drive again what is finished.
        recordings: Keep every tick, for `Run.why`, rescoring and replays.
        penalties: Makes infractions a score: "lb1.0", as Longest6, or "lb2.1".
        isolate: Keep the planner in a process of its own: one that hangs, leaks or crashes costs
            its own episode. A "command:PROGRAM" always has one.
        executor: "local" for processes of this machine, "ray" for a Ray cluster.
        address: Of the Ray cluster: "HOST:6379" or "ray://HOST:10001"; without it the one that this
            machine is part of.
        shard: Drive one part of the episodes, as "1/8", of a run that several calls share.
        on_event: Told of episodes that start, go on and end (`runner.run.suite`).

    Raises:
        InputError: The request cannot be met, or the folder belongs to another one.
        SimulationError: Worker processes do not start.
    """
    from plant_bench.api.run import Run

    if repetitions < 1:
        message = f"repetitions: expected 1 at least, got {repetitions}."
        raise InputError(message)
    resolved = resolve(planner)
    how = Driving(
        cores() if workers is None else workers,
        executor=chosen_executor(executor, address, workers, _log.warning),
        shard=None if shard is None else Shard.parse(shard),
        overwrite=overwrite,
        recordings=recordings,
        penalties=penalty_scheme_of(penalties),
        isolation=isolation_for(resolved.spec, isolate=isolate),
    )
    request = ScoreRequest(
        resolved.spec, os.fspath(suite), routes, repetitions, seed, density, hazards
    )
    folder = resolved.run_folder(request) if out is None else Path(out)
    run = drive_missing(request, folder, how, silent_monitor(on_event))
    for failure in failures_of(run):
        _log.warning("%s", failure)
    found = Run(run.folder.path, how.penalties)
    if not run.unfinished_by_others():
        found.write_summary()
    return found


def drive_missing(
    request: ScoreRequest, out: Path | None, how: Driving, monitor: RunMonitor
) -> OpenRun:
    """Drive what of a run has no record.

    Args:
        request: What is asked for.
        out: The run's folder; None for `reports/<run name>`.
        how: Who drives it.
        monitor: Given the run, before anything of it is driven, returns who is told how it goes,
            as a context.

    Raises:
        PlantBenchError: The run cannot be started or cannot go on.
        KeyboardInterrupt: It was stopped; what is finished is kept and summed up.
    """
    with ExitStack() as hold:
        executor = how.executor or LocalExecutor(
            how.workers, preloader(request.agent, isolate=how.isolation is not None)
        )
        hold.enter_context(executor.connected())  # before the run's folder is made
        load = loader_of(how.isolation)  # this process loads planners, too
        run = open_run(
            request, out, overwrite=how.overwrite, shard=how.shard, lock_stack=hold, load=load
        )
        try:
            with monitor(run) as listener:
                run_suite(
                    run.missing,
                    run.folder,
                    workers=how.workers,
                    recordings=how.recordings,
                    on_event=listener,
                    executor=executor,
                    isolation=how.isolation,
                )
        except KeyboardInterrupt:
            _keep(run, how.penalties)
            raise
        run.remove_partial_files()
    return run


def failures_of(run: OpenRun) -> list[Failure]:
    """Return which episodes failed for another reason than driving: at most one row a status."""
    results = [run.folder.record(episode_name(job)) for job in run.jobs]
    found = []
    for status in FAILURES:
        failed = [result for result in results if result is not None and result.status is status]
        if failed:
            first = failed[0]
            found.append(Failure(status, len(failed), len(run.jobs), first.route, first.reason))
    return found


def silent_monitor(on_event: Listener | None = None) -> RunMonitor:
    """Return a monitor that shows nothing, and hands events on if anybody wants them."""

    @contextmanager
    def monitor(run: OpenRun) -> Iterator[Listener]:
        for note in run.notes:
            _log.info("%s", note)
        yield on_event or _ignore

    return monitor


def _ignore(event: SuiteEvent) -> None:
    del event


def _keep(run: OpenRun, penalties: PenaltyScheme) -> None:
    """Sum up what is finished of a run that was stopped."""
    from plant_bench.runner.run.summary_files import write_summary

    run.remove_partial_files()
    left = run.unfinished()
    if left < len(run.jobs) and not run.others:
        write_summary(run.folder, missing=left, penalties=penalties)
