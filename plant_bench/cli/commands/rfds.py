"""`plant-bench rfds`: scores how well a planner ranks the relevance of vehicles."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.api.execution import ExecutorKind, chosen_executor
from plant_bench.api.numbers import HIGHEST_SEED
from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import (
    CORES,
    AddressOption,
    DensityOption,
    ExecutorOption,
    HazardsOption,
    ManyWorkersOption,
    OverwriteOption,
    PenaltiesOption,
    RepetitionsOption,
    RoutesOption,
    SuiteOption,
    print_note,
)

RANKER_HELP = (
    "attention (the planner's own ranking) or masking (leave-one-out, for any planner); without a "
    "planner: distance, random, oracle (the actor the expert brakes for) or none. Repeat the "
    "option for several. Default: attention, or masking if the planner has no ranking."
)


def score_rfds(
    agent: Annotated[
        str | None,
        typer.Option(help="Planner whose ranking is scored, as for `plant-bench score`."),
    ] = None,
    ranker: Annotated[list[str] | None, typer.Option(help=RANKER_HELP)] = None,
    suite: SuiteOption = "longest6",
    routes: RoutesOption = None,
    repetitions: RepetitionsOption = 3,
    seed: Annotated[int, number_option("Base seed of the traffic.", 0, HIGHEST_SEED)] = 0,
    density: DensityOption = "dense",
    hazards: HazardsOption = True,
    workers: ManyWorkersOption = None,
    executor: ExecutorOption = ExecutorKind.LOCAL,
    address: AddressOption = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder with a sub-folder for each run. Default: as for `score`."),
    ] = None,
    overwrite: OverwriteOption = False,
    recordings: Annotated[
        bool, typer.Option(help="Record every tick, for rescoring and replays.")
    ] = False,
    penalties: PenaltiesOption = "lb1.0",
) -> None:
    """Score how well a planner ranks the relevance of vehicles: relative filtered driving score.

    The expert drives, and observes only the vehicle that is ranked most relevant at each decision
    (pedestrians and traffic lights are not filtered). RFDS is its driving score in percent of the
    unfiltered expert's, on the same routes and seeds. The planner itself does not drive.
    Runs are stored like those of `plant-bench score --agent expert` and `--agent
    expert-filtered@RANKER:AGENT`; the same command again continues them.

    Example commands:

        plant-bench rfds --agent plant

        plant-bench rfds --agent plant@models/mine --ranker attention --ranker distance --routes 0-5

        plant-bench rfds --agent rule-based --ranker masking
    """
    from plant_bench.api.rfds import RelevanceRequest, score_relevance
    from plant_bench.api.score import ExecutionSettings
    from plant_bench.cli.run_progress import RunMonitor, print_failures
    from plant_bench.reports.tables import print_relative_scores
    from plant_bench.runner.run.score_run import ScoreRequest
    from plant_bench.scoring.penalties import penalty_scheme_of

    settings = ExecutionSettings(
        workers=workers or CORES,
        overwrite=overwrite,
        recordings=recordings,
        penalties=penalty_scheme_of(penalties),
        executor=chosen_executor(executor, address, workers, print_note),
    )
    episodes = ScoreRequest("expert", suite, routes, repetitions, seed, density, hazards)
    request = RelevanceRequest(agent, ranker or (), episodes, out)
    monitor = RunMonitor(settings.penalties, named=True)
    with monitor.exit_on_ctrl_c():
        result = score_relevance(request, settings, monitor)
    print_relative_scores(result.scores)
    for run in result.runs:
        typer.echo(f"Records: {run.folder.path}")
    raise typer.Exit(max(print_failures(run) for run in result.runs))
