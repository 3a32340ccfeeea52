"""`plant-bench rescore`: scores recordings again, without the simulator."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.options import PenaltiesOption

if TYPE_CHECKING:
    from plant_bench.runner.run.rescore_run import Rescored


def rescore_run(
    run: Annotated[Path, typer.Argument(help="Folder of a run with recordings.")],
    penalties: PenaltiesOption = "lb1.0",
) -> None:
    """Score a run's recordings again, without the simulator, and compare with its records.

    The new records and their summary are written to RUN/rescored. Exit code 1 if a record differs.

    Example commands:

        plant-bench rescore reports/expert-longest6

        plant-bench rescore reports/expert-longest6 --penalties lb2.1
    """
    from plant_bench.api.rescore import rescore_run as rescore
    from plant_bench.reports.tables import print_summary
    from plant_bench.scoring.penalties import penalty_scheme_of

    chosen = penalty_scheme_of(penalties)

    def print_difference(episode: "Rescored") -> None:
        if episode.again is None:
            typer.echo(f"{episode.name}: no recording", err=True)
        elif not episode.equal:
            typer.echo(
                f"{episode.name}: DS {episode.first.driving_score_by(chosen):.3f} before, "
                f"{episode.again.driving_score_by(chosen):.3f} now; first difference: "
                f"{episode.first_difference}",
                err=True,
            )

    rescored = rescore(run, penalties=chosen, on_episode=print_difference)
    if rescored.summary is not None:
        print_summary(rescored.summary)
    typer.echo(
        f"{rescored.equal} of {rescored.total} records are equal, {rescored.absent} have no "
        "recording."
    )
    if not rescored.agrees:
        raise typer.Exit(1)
