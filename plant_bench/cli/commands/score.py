"""`plant-bench score`."""

import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.api.execution import Where, chosen_executor, isolation_for
from plant_bench.cli.options import (
    CORES,
    AddressOption,
    DensityOption,
    ExecutorOption,
    IsolateOption,
    LawOption,
    ManyWorkersOption,
    MemoryLimitOption,
    OverwriteOption,
    RepetitionsOption,
    RoutesOption,
    StartUpLimitOption,
    SuiteOption,
    TickLimitOption,
    say_aside,
)
from plant_bench.garbage import collect_rarely
from plant_bench.runner.workers.executors import LocalExecutor
from plant_bench.runner.workers.loading import loading

if TYPE_CHECKING:
    from plant_bench.api.score import Driving
    from plant_bench.runner.run.score_run import ScoreRequest


def score(
    agent: Annotated[
        str,
        typer.Option(
            help="A name of `plant-bench agents`, module:Class or file.py:Class; weights after an "
            "@, as in plant@models/mine. Or command:PROGRAM for one in another process."
        ),
    ],
    suite: SuiteOption = "longest6",
    routes: RoutesOption = None,
    repetitions: RepetitionsOption = 3,
    seed: Annotated[int, typer.Option(help="Base seed of traffic; equal for all agents.")] = 0,
    density: DensityOption = "dense",
    hazards: Annotated[
        bool, typer.Option(help="Play the routes' hazards; without them it is another protocol.")
    ] = True,
    workers: ManyWorkersOption = None,
    executor: ExecutorOption = Where.LOCAL,
    address: AddressOption = None,
    shard: Annotated[
        str | None,
        typer.Option(
            help="Drive one part of the episodes, as 1/8 (1 to 8): for array jobs that share --out."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="The run's folder; reports/AGENT-SUITE without it.")
    ] = None,
    overwrite: OverwriteOption = False,
    recordings: Annotated[
        bool, typer.Option(help="Keep every tick, for rescoring and replays.")
    ] = True,
    law: LawOption = "lb1.0",
    isolate: IsolateOption = False,
    tick_limit: TickLimitOption = None,
    start_up_limit: StartUpLimitOption = None,
    memory_limit: MemoryLimitOption = None,
) -> None:
    """Drive a suite and say how well.

    The same command again runs only what is missing, so a run may be stopped with Ctrl-C at any
    time. An episode that crashes is recorded and stays in every mean.

    For instance:

        plant-bench score --agent expert --routes 0 --repetitions 1

        plant-bench score --agent rule-based --repetitions 3 --workers 2

        plant-bench score --agent my_agent.py:MyAgent --routes 0,3-5 --out reports/first-try

        plant-bench score --agent plant --executor ray --address ray://head:10001
    """
    collect_rarely()
    cluster = chosen_executor(executor, address, workers, say_aside)
    here = LocalExecutor(workers or CORES, loading(agent, isolate=isolate))
    # First of all, since its workers load what they need while this process does.
    with here.connected() if cluster is None else nullcontext():
        from plant_bench.api.score import Driving
        from plant_bench.runner.run.lock import Shard
        from plant_bench.runner.run.score_run import ScoreRequest
        from plant_bench.scoring.laws import law_of

        how = Driving(
            workers=workers or CORES,
            overwrite=overwrite,
            recordings=recordings,
            law=law_of(law),
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
            ),
        )
        request = ScoreRequest(agent, suite, routes, repetitions, seed, density, hazards)
        code = _drive(request, out, how)
    raise typer.Exit(code)


def _drive(request: "ScoreRequest", out: Path | None, how: "Driving") -> int:
    """Drive a run to its end, or until Ctrl-C, and print what it scores.

    Returns:
        The exit code: 2 if the agent failed in an episode, 1 if the simulator did.
    """
    from plant_bench.api.score import drive_missing
    from plant_bench.cli.run_progress import Watch, say_crashes

    start = time.monotonic()
    watch = Watch(how.law)
    with watch.ending_at_ctrl_c():
        run = drive_missing(request, out, how, watch)
    from plant_bench.reports.tables import print_planner_time, print_speed, print_summary
    from plant_bench.runner.episode.jobs import episode_name
    from plant_bench.runner.run.speed import read_timings, speed_of, write_speed
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
