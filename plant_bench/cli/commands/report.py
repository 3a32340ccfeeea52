"""`plant-bench report`."""

import math
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.options import CORES, PenaltiesOption, WorkersOption
from plant_bench.cli.progress import ending_at_ctrl_c, progress_bars

if TYPE_CHECKING:
    from rich.progress import TaskID

    from plant_bench.reports.leaderboard.board import Leaderboard
    from plant_bench.scoring.penalties import PenaltyScheme

WIDTH = 34  # of what the bar tells, characters


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
    penalties: PenaltiesOption = "lb1.0",
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
    from plant_bench.api.report import PAGE
    from plant_bench.scoring.penalties import penalty_scheme_of

    chosen = penalty_scheme_of(penalties)
    with ending_at_ctrl_c():
        leaderboard = _write(
            runs or [],
            out,
            penalties=chosen,
            paper=paper,
            replays=replays,
            expert=expert,
            workers=workers,
        )
        for note in leaderboard.notes:
            typer.echo(note, err=True)
        _say_who_leads(leaderboard)
        typer.echo(f"Open {out / PAGE} in a browser.")


def _write(
    runs: list[Path],
    out: Path,
    *,
    penalties: "PenaltyScheme",
    paper: bool,
    replays: bool,
    expert: bool,
    workers: int,
) -> "Leaderboard":
    """Write the leaderboard, with bars on standard error."""
    from rich.markup import escape
    from rich.progress import TextColumn

    from plant_bench.api.report import write_report
    from plant_bench.text_escaping import table_cell

    bars = progress_bars(WIDTH, TextColumn("{task.completed:.0f}/{task.total:.0f}"))
    with ExitStack() as shown:
        tasks: dict[str, TaskID] = {}

        def begin(what: str, steps: int) -> None:
            if "steps" in tasks:
                bars.advance(tasks["steps"])  # a step is done when the next one starts
            else:
                shown.enter_context(bars)
                tasks["steps"] = bars.add_task("", total=steps)
            text = f"{escape(table_cell(what, WIDTH)):<{WIDTH}}"
            bars.update(tasks["steps"], description=text)

        def show_replays(done: int, total: int) -> None:
            if "replays" not in tasks:
                bars.advance(tasks["steps"])
                tasks["replays"] = bars.add_task(f"{'replays':<{WIDTH}}", total=total)
            bars.update(tasks["replays"], completed=done, total=total)

        found = write_report(
            runs,
            out,
            penalties=penalties,
            paper=paper,
            replays=replays,
            expert=expert,
            workers=workers,
            on_step=begin,
            on_replay=show_replays,
        )
        if "replays" not in tasks:
            bars.advance(tasks["steps"])
    return found


def _say_who_leads(leaderboard: "Leaderboard") -> None:
    """Say the order of each board, and whether the first two can be told apart."""
    from plant_bench.reports.leaderboard.table_text import p_text
    from plant_bench.text_escaping import table_cell

    for board in leaderboard.boards:
        scores = [
            f"{table_cell(line.planner)} {line.driving_score.mean:.1f}" for line in board.rows
        ]
        typer.echo(f"{board.protocol} ({board.world}): DS {', '.join(scores)}")
        top = {line.id for line in board.rows[:2]}
        for item in board.differences:
            if {item.better, item.worse} == top:
                paired = item.paired
                interval = (
                    "on too few routes for an interval"
                    if math.isnan(paired.low)
                    else f"95 % interval {paired.low:.1f} to {paired.high:.1f}, "
                    f"p {p_text(item.p_corrected)}"
                )
                typer.echo(f"  first against second: {paired.mean:+.1f} DS, {interval}")
