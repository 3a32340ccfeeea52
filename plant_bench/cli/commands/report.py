"""`plant-bench report`: writes the leaderboard of several runs."""

import math
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant_bench.cli.options import CORES, PenaltiesOption, WorkersOption
from plant_bench.cli.progress import exit_on_ctrl_c, progress_bars

if TYPE_CHECKING:
    from rich.progress import TaskID

    from plant_bench.reports.leaderboard.board import Leaderboard
    from plant_bench.scoring.penalties import PenaltyScheme

WIDTH = 34  # characters of a bar's description
LONGEST_RULES = 120  # characters


def report(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Folders of runs and of `plant-bench rfds`, and checkpoint files of CARLA's "
            "leaderboard (.json, .json.gz, or a folder of them; NAME=PATH, repeated, for a planner "
            "in several files). Default: all in reports/."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Output folder.")] = Path("reports/leaderboard"),
    penalties: PenaltiesOption = "lb1.0",
    paper: Annotated[
        bool,
        typer.Option("--paper", help="Add a table of the results in the PlanT paper (CARLA)."),
    ] = False,
    replays: Annotated[
        bool, typer.Option(help="Include a replay of each recorded episode.")
    ] = True,
    expert: Annotated[
        bool,
        typer.Option(
            "--expert", help="Mark in replays the actor that the expert would brake for; slow."
        ),
    ] = False,
    against_last: Annotated[
        bool,
        typer.Option(
            "--against-last",
            help="Also list the previous version of each run's planner, from RUN/superseded.",
        ),
    ] = False,
    workers: WorkersOption = CORES,
) -> None:
    """Write a leaderboard of runs: an HTML page, tables for papers, and files for programs.

    Open OUT/leaderboard.html in a browser; it needs neither server nor network. Runs of different
    protocols or suites, and files about different routes, are never in the same table. A run that
    lacks some of a table's routes is marked, comes last and is never the best.

    Example commands:

        plant-bench report

        plant-bench report reports/expert-longest6 reports/plant-longest6 --paper

        plant-bench report reports/* --out leaderboard --no-replays

        plant-bench report reports/my_agent.py_MyAgent-longest6 --against-last

        plant-bench report mine=results/part_0.json mine=results/part_1.json theirs=their_folder
    """
    from plant_bench.api.report import PAGE
    from plant_bench.scoring.penalties import penalty_scheme_of

    chosen = penalty_scheme_of(penalties)
    with exit_on_ctrl_c():
        leaderboard = _write(
            runs or [],
            out,
            penalties=chosen,
            paper=paper,
            replays=replays,
            expert=expert,
            workers=workers,
            against_last=against_last,
        )
        for note in leaderboard.notes:
            typer.echo(note, err=True)
        _print_ranking(leaderboard)
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
    against_last: bool,
) -> "Leaderboard":
    """Write the leaderboard, with progress bars on standard error."""
    from rich.markup import escape
    from rich.progress import TextColumn

    from plant_bench.api.report import write_report
    from plant_bench.text_escaping import table_cell

    bars = progress_bars(WIDTH, TextColumn("{task.completed:.0f}/{task.total:.0f}"))
    with ExitStack() as shown:
        tasks: dict[str, TaskID] = {}

        def begin(description: str, steps: int) -> None:
            if "steps" in tasks:
                bars.advance(tasks["steps"])  # a step is done when the next one starts
            else:
                shown.enter_context(bars)
                tasks["steps"] = bars.add_task("", total=steps)
            text = f"{escape(table_cell(description, WIDTH)):<{WIDTH}}"
            bars.update(tasks["steps"], description=text)

        def show_replays(done: int, total: int) -> None:
            if "replays" not in tasks:
                bars.advance(tasks["steps"])
                tasks["replays"] = bars.add_task(f"{'replays':<{WIDTH}}", total=total)
            bars.update(tasks["replays"], completed=done, total=total)

        leaderboard = write_report(
            runs,
            out,
            penalties=penalties,
            paper=paper,
            replays=replays,
            expert=expert,
            workers=workers,
            against_last=against_last,
            on_step=begin,
            on_replay=show_replays,
        )
        if "replays" not in tasks:
            bars.advance(tasks["steps"])
    return leaderboard


def _print_ranking(leaderboard: "Leaderboard") -> None:
    """Print the ranking of each board, and the difference between its first two planners."""
    from plant_bench.reports.leaderboard.table_text import board_rules, p_text, planner_text
    from plant_bench.text_escaping import table_cell

    for board in leaderboard.boards:
        scores = [
            f"{table_cell(planner_text(board, row))} {row.driving_score.mean:.1f}"
            for row in board.rows
        ]
        rules = table_cell(board_rules(board), LONGEST_RULES)
        typer.echo(f"{rules} ({board.world}): DS {', '.join(scores)}")
        names = {row.id: table_cell(row.planner) for row in board.rows}
        top = {row.id for row in board.rows[:2]}
        for item in board.differences:
            if {item.better, item.worse} == top:
                paired = item.paired
                interval = (
                    "too few routes for a confidence interval"
                    if math.isnan(paired.low)
                    else f"95 % interval {paired.low:.1f} to {paired.high:.1f}, "
                    f"p {p_text(item.p_corrected)}"
                )
                verdict = f", {item.verdict.value}" if not math.isnan(paired.low) else ""
                typer.echo(
                    f"  {names[item.better]} against {names[item.worse]}: {paired.mean:+.1f} DS, "
                    f"{interval}{verdict}"
                )
