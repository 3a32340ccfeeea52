"""What `plant-bench report` does: find runs, read them, write the leaderboard's files."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import typer
from rich.markup import escape
from rich.progress import Progress, TextColumn

from plant_bench.cli.bars import progress_bars
from plant_bench.foreign_text import table_cell
from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.leaderboard.boards import make_leaderboard
from plant_bench.reports.leaderboard.exports import write_exports
from plant_bench.reports.leaderboard.figures import write_figures
from plant_bench.reports.leaderboard.page import write_page
from plant_bench.reports.leaderboard.replays import replay_sources
from plant_bench.reports.leaderboard.sources import Sources, find_sources
from plant_bench.reports.leaderboard.texts import p_text
from plant_bench.reports.replay.site import write_replays
from plant_bench.runner.review.expert_asking import ask_expert
from plant_bench.scoring.laws import Law

RUNS = Path("reports")  # where `plant-bench score` puts runs
WIDTH = 34  # of what the bar tells, characters
FURTHER_STEPS = 3  # differences, files, page


def write_report(
    paths: Sequence[Path],
    out: Path,
    *,
    law: Law,
    paper: bool,
    replays: bool,
    expert: bool,
    workers: int,
) -> None:
    """Read runs and write the leaderboard, with a bar on standard error.

    Raises:
        InputError: There is nothing to report, or a source cannot be read.
        OSError: The files cannot be written.
    """
    sources = find_sources(paths, below=RUNS)
    with progress_bars(WIDTH, TextColumn("{task.completed:.0f}/{task.total:.0f}")) as bars:
        task = bars.add_task("", total=_steps(sources))

        def progress(what: str) -> None:
            bars.update(task, description=f"{escape(table_cell(what, WIDTH)):<{WIDTH}}", advance=1)

        bars.update(task, completed=-1)  # a step is done when the next one starts
        leaderboard = make_leaderboard(sources, law=law, paper=paper, progress=progress)
        progress("files")
        write_exports(leaderboard, out)
        write_figures(leaderboard, out)
        progress("page")
        write_page(leaderboard, out, replays=replays)
        bars.update(task, advance=1)
        if replays:
            _write_replays(leaderboard, out, workers, bars, expert=expert)
    for note in leaderboard.notes:
        typer.echo(note, err=True)
    _say_who_leads(leaderboard, typer.echo)
    typer.echo(f"Open {out / 'leaderboard.html'} in a browser.")


def _write_replays(
    leaderboard: Leaderboard, out: Path, workers: int, bars: Progress, *, expert: bool
) -> None:
    """Make the replays that are not there yet, with a bar of their own.

    Raises:
        InputError: They cannot be written.
    """
    sources = replay_sources(leaderboard, ask_expert if expert else None)
    task = bars.add_task(f"{'replays':<{WIDTH}}", total=len(sources))
    write_replays(
        out,
        sources,
        workers=workers,
        progress=lambda done, total: bars.update(task, completed=done, total=total),
    )


def _steps(sources: Sources) -> int:
    read = (sources.runs, sources.rankings, sources.checkpoints)
    return sum(map(len, read)) + FURTHER_STEPS


def _say_who_leads(leaderboard: Leaderboard, say: Callable[[str], None]) -> None:
    """Say the order of each board, and whether the first two can be told apart."""
    for board in leaderboard.boards:
        scores = [
            f"{table_cell(line.planner)} {line.driving_score.mean:.1f}" for line in board.lines
        ]
        say(f"{board.protocol} ({board.world}): DS {', '.join(scores)}")
        top = {line.id for line in board.lines[:2]}
        for item in board.differences:
            if {item.better, item.worse} == top:
                paired = item.paired
                interval = (
                    "on too few routes for an interval"
                    if math.isnan(paired.low)
                    else f"95 % interval {paired.low:.1f} to {paired.high:.1f}, "
                    f"p {p_text(item.p_corrected)}"
                )
                say(f"  first against second: {paired.mean:+.1f} DS, {interval}")
