"""`plant-bench compare`: tests whether one run scores better than another."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.number_options import number_option
from plant_bench.cli.options import PenaltiesOption
from plant_bench.errors import InputError

if TYPE_CHECKING:
    from plant_bench.scoring.comparison import PairedDifference
    from plant_bench.scoring.penalties import PenaltyScheme

MOST_ROUTES = 1_000_000


def compare_runs(
    first: Annotated[
        Path,
        typer.Argument(help="Folder of the baseline run, or of the run to compare with its past."),
    ],
    second: Annotated[Path | None, typer.Argument(help="Folder of the new run.")] = None,
    against_last: Annotated[
        bool,
        typer.Option(
            "--against-last",
            help="Compare a run with the previous version of its own planner, whose episodes are "
            "in RUN/superseded.",
        ),
    ] = False,
    top: Annotated[
        int,
        number_option("Number of routes to list, the largest differences first.", 0, MOST_ROUTES),
    ] = 10,
    all_routes: Annotated[
        bool, typer.Option("--all", help="List all routes on which the runs differ.")
    ] = False,
    penalties: PenaltiesOption = "lb1.0",
) -> None:
    """Test whether the second run scores better or worse than the first.

    Episodes are paired by route and seed, so both runs had the same traffic. A difference in
    driving score is significant if the p-value is at most 0.05 and the 95 % interval excludes zero.
    Exit code 1 on a regression: the second run is significantly worse.

    Example commands:

        plant-bench compare reports/rule-based-longest6 reports/my_agent.py_MyAgent-longest6

        plant-bench compare reports/my_agent.py_MyAgent-longest6 --against-last
    """
    from plant_bench.reports.comparison_table import print_difference
    from plant_bench.scoring.comparison import Verdict

    difference, names, scheme = _difference(first, second, against_last, penalties)
    print_difference(difference, *names, penalties=scheme, routes=None if all_routes else top)
    if difference.verdict is Verdict.WORSE:
        raise typer.Exit(1)


def _difference(
    first: Path, second: Path | None, against_last: bool, penalties: str
) -> tuple["PairedDifference", tuple[str, str], "PenaltyScheme"]:
    """Return the difference, the names of both runs and the penalty scheme."""
    from plant_bench.api.run import load_run

    if against_last:
        if second is not None:
            message = f"--against-last compares one run: leave out {second}."
            raise InputError(message)
        run = load_run(first, penalties=penalties)
        return run.compare_with_previous(), (f"{first} (previous)", str(first)), run.penalties
    if second is None:
        message = "Give the folder of a second run, or --against-last."
        raise InputError(message)
    new = load_run(second, penalties=penalties)
    base = load_run(first, penalties=penalties)
    return new.compare(base), (str(first), str(second)), new.penalties
