"""`plant-bench rescore` and `plant-bench compare`."""

from pathlib import Path
from typing import Annotated

import typer

LAW_HELP = "Makes infractions a score: lb1.0, as Longest6, or lb2.1; records do not depend on it."


def rescore_run(
    run: Annotated[Path, typer.Argument(help="A folder that `plant-bench score` wrote.")],
    law: Annotated[str, typer.Option(help=LAW_HELP)] = "lb1.0",
) -> None:
    """Score a run's recordings again, without the simulator, and say whether the records agree.

    The new records and their summary are in RUN/rescored. Exit code 1 where a record differs.

    For instance:

        plant-bench rescore reports/expert-longest6

        plant-bench rescore reports/expert-longest6 --law lb2.1
    """
    from plant_bench.reports.tables import print_summary
    from plant_bench.runner.run.folder import RunFolder
    from plant_bench.runner.run.rescoring import rescore_folder
    from plant_bench.runner.run.summary import write_rescored_summary
    from plant_bench.scoring.laws import law_of

    chosen = law_of(law)
    folder = RunFolder.open(run)
    total = equal = absent = 0
    again = []
    for episode in rescore_folder(folder):
        total += 1
        equal += episode.equal
        if episode.again is None:
            absent += 1
            typer.echo(f"{episode.name}: no recording", err=True)
            continue
        again.append(episode.again)
        if not episode.equal:
            typer.echo(
                f"{episode.name}: DS {episode.first.driving_score_by(chosen):.3f} before, "
                f"{episode.again.driving_score_by(chosen):.3f} now",
                err=True,
            )
    if again:
        print_summary(write_rescored_summary(folder, again, missing=absent, law=chosen))
    typer.echo(f"{equal} of {total} records are equal, {absent} have no recording.")
    if equal + absent < total:
        raise typer.Exit(1)


def compare_runs(
    first: Annotated[Path, typer.Argument(help="The run to compare with.")],
    second: Annotated[Path, typer.Argument(help="The run in question.")],
    law: Annotated[str, typer.Option(help=LAW_HELP)] = "lb1.0",
) -> None:
    """Say whether the second run is better or worse than the first.

    Episodes are paired by route and seed, so that both have driven in the same traffic. Exit code 1
    on a regression: where the whole interval of the difference in driving score is below zero.

    For instance:

        plant-bench compare reports/rule-based-longest6 reports/my_agent.py_MyAgent-longest6
    """
    from plant_bench.reports.tables import print_difference
    from plant_bench.runner.run.folder import RunFolder
    from plant_bench.scoring.comparison import paired_difference
    from plant_bench.scoring.laws import law_of

    chosen = law_of(law)
    base, new = RunFolder.open(first).results(), RunFolder.open(second).results()
    difference = paired_difference(base, new, law=chosen)
    print_difference(difference, str(first), str(second), law=chosen)
    if difference.high < 0:
        raise typer.Exit(1)
