"""`plant-bench score`."""

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from plant_bench.runner.run import Run

EXIT_INTERRUPTED = 130


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def score(
    agent: Annotated[
        str, typer.Option(help="A name of `plant-bench agents`, module:Class or file.py:Class.")
    ],
    suite: Annotated[
        str, typer.Option(help="A suite's name, or a folder or file of routes.")
    ] = "longest6",
    routes: Annotated[
        str | None,
        typer.Option(help="Numbers, ranges and ids, as in 0,3-5,town02-1; all without it."),
    ] = None,
    repetitions: Annotated[int, typer.Option(help="Episodes on each route.", min=1)] = 3,
    seed: Annotated[int, typer.Option(help="Base seed of traffic; equal for all agents.")] = 0,
    density: Annotated[str, typer.Option(help="Of the traffic.")] = "dense",
    workers: Annotated[
        int, typer.Option(help="Processes; scores do not depend on it.", min=1)
    ] = _cores(),
    out: Annotated[
        Path | None, typer.Option(help="The run's folder; reports/<agent>-<suite> without it.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Run again what is finished.")
    ] = False,
    recordings: Annotated[
        bool, typer.Option(help="Keep every tick, for rescoring and replays.")
    ] = True,
) -> None:
    """Drive a suite and say how well.

    The same command again runs only what is missing, so a run may be stopped with Ctrl-C at any
    time. An episode that crashes is recorded and stays in every mean.

    Examples:

        plant-bench score --agent expert --routes 0 --repetitions 1

        plant-bench score --agent rule-based --repetitions 3 --workers 2

        plant-bench score --agent my_agent.py:MyAgent --routes 0,3-5 --out reports/first-try
    """
    from plant_bench.cli.progress import RunProgress
    from plant_bench.runner.run import ScoreRequest, open_run
    from plant_bench.runner.suite import run_suite

    request = ScoreRequest(agent, suite, routes, repetitions, seed, density)
    run = open_run(request, out, overwrite=overwrite)
    for note in run.notes:
        typer.echo(note, err=True)
    start = time.monotonic()
    try:
        with RunProgress(run.jobs, run.missing) as progress:
            run_suite(
                run.missing,
                run.folder,
                workers=workers,
                recordings=recordings,
                on_event=progress,
            )
    except KeyboardInterrupt:
        _say_stopped(run)
        raise typer.Exit(EXIT_INTERRUPTED) from None
    _report(run, workers, time.monotonic() - start)


def _say_stopped(run: "Run") -> None:
    left = sum(run.folder.record(job) is None for job in run.jobs)
    typer.echo(
        f"Stopped. {len(run.jobs) - left} of {len(run.jobs)} episodes are finished and kept in "
        f"{run.folder.path}. The same command again runs the other {left}.",
        err=True,
    )


def _report(run: "Run", workers: int, wall_s: float) -> None:
    from plant_bench.reports.tables import print_latency, print_speed, print_summary
    from plant_bench.runner.summary import write_summary

    summary = write_summary(run.folder)
    print_summary(summary)
    timings = run.folder.timings()
    print_latency(timings)
    print_speed(run.folder.timings_of(run.missing), timings, workers=workers, wall_s=wall_s)
    typer.echo(f"Records: {run.folder.path}")
