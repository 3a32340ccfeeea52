"""`plant-bench rfds`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.execution import Where, chosen_executor
from plant_bench.cli.options import (
    CORES,
    AddressOption,
    DensityOption,
    ExecutorOption,
    LawOption,
    ManyWorkersOption,
    OverwriteOption,
    RepetitionsOption,
    RoutesOption,
    SuiteOption,
    say_aside,
)

RANKER_HELP = (
    "attention (the planner's own ranking), masking (one vehicle taken out at a time, for any "
    "planner); or, without a planner: distance, random, oracle (whom the expert brakes for), none. "
    "May be given several times; attention without it, masking for planners that do not rank."
)


def score_rfds(
    agent: Annotated[
        str | None, typer.Option(help="Whose ranking is scored; as for `plant-bench score`.")
    ] = None,
    ranker: Annotated[list[str] | None, typer.Option(help=RANKER_HELP)] = None,
    suite: SuiteOption = "longest6",
    routes: RoutesOption = None,
    repetitions: RepetitionsOption = 3,
    seed: Annotated[int, typer.Option(help="Base seed of traffic.")] = 0,
    density: DensityOption = "dense",
    hazards: Annotated[bool, typer.Option(help="Play the routes' hazards.")] = True,
    workers: ManyWorkersOption = None,
    executor: ExecutorOption = Where.LOCAL,
    address: AddressOption = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the runs, one each; without it where `score` puts them."),
    ] = None,
    overwrite: OverwriteOption = False,
    recordings: Annotated[
        bool, typer.Option(help="Keep every tick, for rescoring and replays.")
    ] = False,
    law: LawOption = "lb1.0",
) -> None:
    """Say how well a planner knows which vehicle matters: the relative filtered driving score.

    The expert drives seeing, of all vehicles, only the one that ranks highest at each decision
    (pedestrians and lights stay in sight). RFDS is its driving score in percent of that of the
    expert that sees everybody, on the same routes and seeds. The planner itself need not drive
    well. Runs are kept as `plant-bench score --agent expert` and `--agent
    expert-filtered@RANKER:AGENT` keep them, and go on where they were stopped.

    For instance:

        plant-bench rfds --agent plant

        plant-bench rfds --agent plant@models/mine --ranker attention --ranker distance --routes 0-5

        plant-bench rfds --agent rule-based --ranker masking
    """
    from plant_bench.api.rfds import RelevanceRequest, score_relevance
    from plant_bench.api.score import Driving
    from plant_bench.cli.run_progress import Watch, say_crashes
    from plant_bench.reports.tables import print_relative_scores
    from plant_bench.runner.run.score_run import ScoreRequest
    from plant_bench.scoring.laws import law_of

    how = Driving(
        workers=workers or CORES,
        overwrite=overwrite,
        recordings=recordings,
        law=law_of(law),
        executor=chosen_executor(executor, address, workers, say_aside),
    )
    drives = ScoreRequest("expert", suite, routes, repetitions, seed, density, hazards)
    request = RelevanceRequest(agent, ranker or (), drives, out)
    watch = Watch(how.law, named=True)
    with watch.ending_at_ctrl_c():
        found = score_relevance(request, how, watch)
    print_relative_scores(found.scores)
    for run in found.runs:
        typer.echo(f"Records: {run.folder.path}")
    raise typer.Exit(max(say_crashes(run) for run in found.runs))
