"""`plant-bench compare`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import PenaltiesOption


def compare_runs(
    first: Annotated[Path, typer.Argument(help="The run to compare with.")],
    second: Annotated[Path, typer.Argument(help="The run in question.")],
    penalties: PenaltiesOption = "lb1.0",
) -> None:
    """Say whether the second run is better or worse than the first.

    Episodes are paired by route and seed, so that both have driven in the same traffic. Exit code 1
    on a regression: where the whole interval of the difference in driving score is below zero.

    For instance:

        plant-bench compare reports/rule-based-longest6 reports/my_agent.py_MyAgent-longest6
    """
    from plant_bench.api.run import load_run
    from plant_bench.reports.tables import print_difference

    base, new = load_run(first, penalties=penalties), load_run(second, penalties=penalties)
    difference = new.compare(base)
    print_difference(difference, str(first), str(second), penalties=new.penalties)
    if difference.high < 0:
        raise typer.Exit(1)
