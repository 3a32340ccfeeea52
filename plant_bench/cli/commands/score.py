"""`plant-bench score`: drives a route suite with a planner and scores it."""

import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.api.execution import ExecutorKind, chosen_executor, isolation_for
from plant_bench.api.gui import use_gui
from plant_bench.api.numbers import HIGHEST_SEED
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import (
    CORES,
    AddressOption,
    DensityOption,
    ExecutorOption,
    GuiOption,
    GuiSpeedOption,
    HazardsOption,
    IsolateOption,
    ManyWorkersOption,
    MemoryLimitOption,
    OverwriteOption,
    PenaltiesOption,
    RepetitionsOption,
    RoutesOption,
    StartUpLimitOption,
    SuiteOption,
    TickLimitOption,
    print_note,
)
from plant_bench.errors import InputError
from plant_bench.gc_policy import tune_garbage_collector
from plant_bench.runner.workers.executors import LocalExecutor
from plant_bench.runner.workers.preloading import preloader

if TYPE_CHECKING:
    from plant_bench.api.score import ExecutionSettings
    from plant_bench.runner.run.score_run import ScoreRequest


def score(
    agent: Annotated[
        str,
        typer.Option(
            help="Planner: a name listed by `plant-bench agents`, module:Class or file.py:Class, "
            "with weights after an @, e.g. plant@models/mine; or command:PROGRAM for a planner in "
            "a separate program."
        ),
    ],
    suite: SuiteOption = "longest6",
    routes: RoutesOption = None,
    repetitions: RepetitionsOption = 3,
    seed: Annotated[
        int,
        number_option(
            "Base seed of the traffic; use the same one to compare agents.", 0, HIGHEST_SEED
        ),
    ] = 0,
    density: DensityOption = "dense",
    hazards: HazardsOption = True,
    workers: ManyWorkersOption = None,
    executor: ExecutorOption = ExecutorKind.LOCAL,
    address: AddressOption = None,
    shard: Annotated[
        str | None,
        typer.Option(
            help="Drive one part of the episodes: 1/8, 2/8, ..., 8/8 for eight jobs that share "
            "--out."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run. Default: reports/AGENT-SUITE.")
    ] = None,
    overwrite: OverwriteOption = False,
    recordings: Annotated[
        bool, typer.Option(help="Record every tick, for rescoring and replays.")
    ] = True,
    penalties: PenaltiesOption = "lb1.0",
    isolate: IsolateOption = False,
    tick_limit: TickLimitOption = None,
    start_up_limit: StartUpLimitOption = None,
    memory_limit: MemoryLimitOption = None,
    gui: GuiOption = False,
    gui_speed: GuiSpeedOption = 1.0,
) -> None:
    """Drive a route suite with a planner and print its scores.

    The same command again drives only the missing episodes, so a run can be stopped with Ctrl-C at
    any time. Crashed episodes are recorded and count in all means.

    Example commands:

        plant-bench score --agent expert --routes 0 --repetitions 1

        plant-bench score --agent rule-based --repetitions 3 --workers 2

        plant-bench score --agent my_agent.py:MyAgent --routes 0,3-5 --out reports/first-try

        plant-bench score --agent plant --executor ray --address ray://head:10001

        plant-bench score --agent expert --routes 0 --repetitions 1 --gui --gui-speed 2
    """
    tune_garbage_collector()
    if gui:
        if executor is not ExecutorKind.LOCAL or workers not in (None, 1):
            message = "--gui shows one episode at a time: use --workers 1, and no cluster."
            raise InputError(message)
        use_gui(gui_speed)
        workers = 1
    cluster = chosen_executor(executor, address, workers, print_note)
    here = LocalExecutor(workers or CORES, preloader(agent, isolate=isolate))
    # Connect first: the workers import their modules while this process imports its own.
    with here.connected() if cluster is None else nullcontext():
        from plant_bench.api.score import ExecutionSettings
        from plant_bench.runner.run.folder import RunFolder
        from plant_bench.runner.run.run_lock import Shard
        from plant_bench.runner.run.score_run import ScoreRequest
        from plant_bench.scoring.penalties import penalty_scheme_of

        request = ScoreRequest(agent, suite, routes, repetitions, seed, density, hazards)
        settings = ExecutionSettings(
            workers=workers or CORES,
            overwrite=overwrite,
            recordings=recordings,
            penalties=penalty_scheme_of(penalties),
            executor=cluster or here,
            shard=None if shard is None else Shard.parse(shard),
            isolation=isolation_for(
                agent,
                isolate=isolate,
                limits={
                    "tick": tick_limit,
                    "start_up": start_up_limit,
                    "memory": memory_limit,
                },
                log=RunFolder(request.folder(out)).planner_log,
            ),
        )
        code = _drive(request, out, settings)
    raise typer.Exit(code)


def _drive(request: "ScoreRequest", out: Path | None, settings: "ExecutionSettings") -> int:
    """Drive the missing episodes of a run until they are finished or Ctrl-C; print the scores.

    Returns:
        The exit code: 2 if the agent failed in an episode, 1 if the simulator did.
    """
    from plant_bench.api.score import drive_missing
    from plant_bench.cli.run_progress import RunMonitor, print_failures

    start = time.monotonic()
    monitor = RunMonitor(settings.penalties)
    with monitor.exit_on_ctrl_c():
        run = drive_missing(request, out, settings, monitor)
    from plant_bench.reports.tables import print_planner_time, print_speed, print_summary
    from plant_bench.runner.episode.jobs import episode_name
    from plant_bench.runner.run.speed import read_timings, speed_of, write_speed
    from plant_bench.runner.run.summary_files import write_summary

    if left := run.unfinished_by_others():
        typer.echo(
            f"Shard {settings.shard} is finished: {len(run.jobs)} episodes. {left} of the "
            f"{len(run.others)} episodes of other shards are not finished; the last shard to "
            "finish writes the summary."
        )
    else:
        print_summary(write_summary(run.folder, penalties=settings.penalties))
        print_planner_time(write_speed(run.folder, map(episode_name, [*run.jobs, *run.others])))
    now = speed_of(read_timings(run.folder, map(episode_name, run.missing)))
    print_speed(now, wall_s=time.monotonic() - start, workers=str(settings))
    if not run.missing:
        typer.echo("Nothing to drive: all episodes are finished.")
    typer.echo(f"Records: {run.folder.path}")
    return print_failures(run)
