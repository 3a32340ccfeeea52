"""`plant-bench compare`: tests whether one run scores better than another."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.options import PenaltiesOption


def compare_runs(
    first: Annotated[Path, typer.Argument(help="Folder of the baseline run.")],
    second: Annotated[Path, typer.Argument(help="Folder of the new run.")],
    penalties: PenaltiesOption = "lb1.0",
) -> None:
    """Test whether the second run scores better or worse than the first.

    Episodes are paired by route and seed, so both runs had the same traffic. Exit code 1 on a
    regression: the confidence interval of the difference in driving score lies below zero.

    Example commands:

        plant-bench compare reports/rule-based-longest6 reports/my_agent.py_MyAgent-longest6
    """
    from plant_bench.api.run import load_run
    from plant_bench.reports.tables import print_difference

    base, new = load_run(first, penalties=penalties), load_run(second, penalties=penalties)
    difference = new.compare(base)
    print_difference(difference, str(first), str(second), penalties=new.penalties)
    if difference.high < 0:
        raise typer.Exit(1)
