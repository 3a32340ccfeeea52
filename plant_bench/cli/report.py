"""`plant-bench report`."""

from pathlib import Path
from typing import Annotated

import typer

from plant_bench.cli.interrupts import ending_at_ctrl_c
from plant_bench.cli.options import CORES, LawOption, WorkersOption


def report(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Folders of runs and of `plant-bench rfds`, checkpoint files of the CARLA "
            "leaderboard; all below reports/ without them."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the leaderboard.")] = Path(
        "reports/leaderboard"
    ),
    law: LawOption = "lb1.0",
    paper: Annotated[
        bool, typer.Option("--paper", help="Show PlanT's own figures, from CARLA, in a table.")
    ] = False,
    replays: Annotated[
        bool, typer.Option(help="Make a replay of each episode that was recorded.")
    ] = True,
    expert: Annotated[
        bool,
        typer.Option("--expert", help="Replays show whom the expert would brake for; slow."),
    ] = False,
    workers: WorkersOption = CORES,
) -> None:
    """Put runs into a leaderboard: a page to look at, files for programs and papers.

    Open OUT/leaderboard.html in a browser; it needs neither server nor network. Runs under
    different protocols or on different suites never share a table.

    For instance:

        plant-bench report

        plant-bench report reports/expert-longest6 reports/plant-longest6 --paper

        plant-bench report reports/* --out leaderboard --no-replays
    """
    from plant_bench.cli.reporting import write_report
    from plant_bench.scoring.laws import law_of

    with ending_at_ctrl_c():
        write_report(
            runs or [],
            out,
            law=law_of(law),
            paper=paper,
            replays=replays,
            expert=expert,
            workers=workers,
        )
