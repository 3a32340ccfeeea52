"""`plant-bench score`."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.executing import (
    AddressOption,
    ExecutorOption,
    ManyWorkersOption,
    Where,
    chosen_executor,
)
from plant_bench.cli.isolating import (
    IsolateOption,
    MemoryLimitOption,
    StartUpLimitOption,
    TickLimitOption,
    isolation_for,
)
from plant_bench.cli.options import (
    CORES,
    DensityOption,
    LawOption,
    OverwriteOption,
    RepetitionsOption,
    RoutesOption,
    SuiteOption,
)
from plant_bench.garbage import collect_rarely
from plant_bench.runner.workers.executors import LocalExecutor
from plant_bench.runner.workers.loading import loading


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
    cluster = chosen_executor(executor, address, workers)
    here = LocalExecutor(workers or CORES, loading(agent, isolate=isolate))
    # First of all, since its workers load what they need while this process does.
    with here.connected() if cluster is None else nullcontext():
        from plant_bench.cli.drive import Driving, drive
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
                tick=tick_limit,
                start_up=start_up_limit,
                memory=memory_limit,
            ),
        )
        request = ScoreRequest(agent, suite, routes, repetitions, seed, density, hazards)
        code = drive(request, out, how)
    raise typer.Exit(code)
