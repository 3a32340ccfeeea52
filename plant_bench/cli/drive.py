"""What `plant-bench score` does: drive what is missing, show it, and sum up all there is."""

import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import typer

from plant_bench.cli.options import EXIT_INTERRUPTED
from plant_bench.cli.progress import RunProgress
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.run.lock import Shard
from plant_bench.runner.run.score_run import Run, ScoreRequest, open_run
from plant_bench.runner.run.speed import read_timings, speed_of, write_speed
from plant_bench.runner.run.suite import run_suite
from plant_bench.runner.workers.executors import Executor, LocalExecutor
from plant_bench.runner.workers.isolation import Isolation, isolated
from plant_bench.runner.workers.loading import loading
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.laws import Law


@dataclass(frozen=True)
class Driving:
    """How a run is driven; its records do not depend on it.

    Attributes:
        workers: Processes, of this machine.
        overwrite: Drive again what is finished.
        recordings: Keep every tick.
        law: By which infractions become scores, in the summary.
        executor: Who drives; None for processes of this machine that begin now.
        shard: The part that is driven here; None for all of it.
        isolation: Keeps the planner in a process of its own; None where the workers load it.
    """

    workers: int
    overwrite: bool = False
    recordings: bool = True
    law: Law = Law.LB1_0
    executor: Executor | None = None
    shard: Shard | None = None
    isolation: Isolation | None = None

    def __str__(self) -> str:
        return str(self.executor or LocalExecutor(self.workers))


def drive(request: ScoreRequest, out: Path | None, how: Driving) -> int:
    """Drive a run to its end, or until Ctrl-C.

    Returns:
        The exit code: 2 if the agent failed in an episode, 1 if the simulator did.

    Raises:
        PlantBenchError: The run cannot be started or cannot go on.
    """
    start = time.monotonic()
    run = drive_missing(request, out, how)
    if run is None:
        return EXIT_INTERRUPTED
    from plant_bench.reports.tables import print_planner_time, print_speed, print_summary
    from plant_bench.runner.run.summary import write_summary

    if left := run.unfinished_by_others():
        typer.echo(
            f"Shard {how.shard} is finished: {len(run.jobs)} episodes. Of the other shards' "
            f"{len(run.others)}, {left} have no record yet; who ends last writes the summary."
        )
    else:
        print_summary(write_summary(run.folder, law=how.law))
        print_planner_time(write_speed(run.folder, map(episode_name, [*run.jobs, *run.others])))
    now = speed_of(read_timings(run.folder, map(episode_name, run.missing)))
    print_speed(now, wall_s=time.monotonic() - start, workers=str(how))
    if not run.missing:
        typer.echo("Nothing was left to drive: these episodes were finished before.")
    typer.echo(f"Records: {run.folder.path}")
    return say_crashes(run)


def drive_missing(request: ScoreRequest, out: Path | None, how: Driving) -> Run | None:
    """Drive what of a run has no record, and show how it goes; None if Ctrl-C ended it.

    Raises:
        PlantBenchError: The run cannot be started or cannot go on.
    """
    with ExitStack() as hold:
        hold.enter_context(isolated(how.isolation))  # this process loads planners, too
        executor = how.executor or LocalExecutor(
            how.workers, loading(request.agent, isolate=how.isolation is not None)
        )
        hold.enter_context(executor.connected())  # before the run's folder is made
        run = open_run(request, out, overwrite=how.overwrite, shard=how.shard, hold=hold)
        for note in run.notes:
            typer.echo(note, err=True)
        progress = RunProgress(run.jobs, run.missing, how.law)
        try:
            with progress.shown():
                run_suite(
                    run.missing,
                    run.folder,
                    workers=how.workers,
                    recordings=how.recordings,
                    on_event=progress,
                    executor=executor,
                    isolation=how.isolation,
                )
        except KeyboardInterrupt:
            _say_stopped(run, how.law)
            return None
        run.sweep()
    return run


def say_crashes(run: Run) -> int:
    """Tell of episodes that failed for another reason than driving; return the exit code."""
    results = [run.folder.record(episode_name(job)) for job in run.jobs]
    code = 0
    for status, exit_code in ((Status.SIMULATION_CRASHED, 1), (Status.AGENT_CRASHED, 2)):
        found = [result for result in results if result is not None and result.status is status]
        if found:
            code = exit_code
            typer.secho(
                f"plant-bench: {len(found)} of {len(run.jobs)} episodes ended with "
                f"'{status.value}', the first on {found[0].route}: {found[0].reason}",
                err=True,
                fg=typer.colors.RED,
            )
    return code


def _say_stopped(run: Run, law: Law) -> None:
    from plant_bench.runner.run.summary import write_summary

    run.sweep()
    left = run.unfinished()
    if left < len(run.jobs) and not run.others:
        write_summary(run.folder, missing=left, law=law)
    typer.echo(
        f"Stopped. {len(run.jobs) - left} of {len(run.jobs)} episodes are finished and kept in "
        f"{run.folder.path}. The same command again runs the other {left}.",
        err=True,
    )
