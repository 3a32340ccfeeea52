"""`plant-bench rescore` and `plant-bench compare`."""

from pathlib import Path
from typing import Annotated

import typer


def rescore_run(
    run: Annotated[Path, typer.Argument(help="A folder that `plant-bench score` wrote.")],
) -> None:
    """Score a run's recordings again, without the simulator, and say whether the records agree.

    The new records are in RUN/rescored. Exit code 1 where one differs.

    For instance:

        plant-bench rescore reports/expert-longest6
    """
    from plant_bench.runner.rescoring import rescore_folder
    from plant_bench.runner.run_folder import RunFolder

    total = equal = absent = 0
    for episode in rescore_folder(RunFolder.open(run)):
        total += 1
        equal += episode.equal
        if episode.again is None:
            absent += 1
            typer.echo(f"{episode.name}: no recording", err=True)
        elif not episode.equal:
            typer.echo(
                f"{episode.name}: DS {episode.first.driving_score:.3f} before, "
                f"{episode.again.driving_score:.3f} now",
                err=True,
            )
    typer.echo(f"{equal} of {total} records are equal, {absent} have no recording.")
    if equal + absent < total:
        raise typer.Exit(1)


def compare_runs(
    first: Annotated[Path, typer.Argument(help="The run to compare with.")],
    second: Annotated[Path, typer.Argument(help="The run in question.")],
) -> None:
    """Say whether the second run is better or worse than the first.

    Episodes are paired by route and seed, so that both have driven in the same traffic. Exit code 1
    on a regression: where the whole interval of the difference in driving score is below zero.

    For instance:

        plant-bench compare reports/rule-based-longest6 reports/my_agent.py_MyAgent-longest6
    """
    from plant_bench.reports.tables import print_difference
    from plant_bench.runner.run_folder import RunFolder
    from plant_bench.scoring.comparison import paired_difference

    base, new = RunFolder.open(first).results(), RunFolder.open(second).results()
    difference = paired_difference(base, new)
    print_difference(difference, str(first), str(second))
    if difference.high < 0:
        raise typer.Exit(1)
