"""Figures of a leaderboard as SVG and PNG: scores, and differences from the first row."""

import math
from pathlib import Path

from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ft2font import FT2Font

from plant_bench.atomic_files import write_whole
from plant_bench.reports.leaderboard.board import Board, Difference, Leaderboard
from plant_bench.reports.leaderboard.table_text import planner_text
from plant_bench.text_escaping import table_cell

KINDS = ("svg", "png")
LONGEST = 28  # characters of a name
ROW = 0.32  # inches
INK, GREY, GOOD, BAD = "#1b1e23", "#565e69", "#17714a", "#ad3029"


def write_figures(leaderboard: Leaderboard, out: Path) -> list[Path]:
    """Write a figure of each board of plant-bench runs, as SVG and PNG; return their paths.

    Raises:
        OSError: A file cannot be written.
    """
    paths = []
    boards = [board for board in leaderboard.boards if board.entries]
    for number, board in enumerate(boards):
        stem = "leaderboard" if number == 0 else f"leaderboard-{number + 1}"
        figure = board_figure(board)
        for kind in KINDS:
            path = out / f"{stem}.{kind}"
            write_whole(path, lambda part, kind=kind, figure=figure: _save(figure, part, kind))
            paths.append(path)
    return paths


def board_figure(board: Board) -> Figure:
    """Draw driving scores with their deviations, and the differences from the first row."""
    names = [drawable(planner_text(board, row)) for row in board.rows]
    figure = Figure(figsize=(8.0, 1.1 + ROW * len(names)), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    _draw_scores(left, board)
    _draw_differences(right, board)
    left.set_yticks(range(len(names)), names)
    left.invert_yaxis()
    for axes in (left, right):
        axes.grid(axis="x", color="#dadde2", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
    return figure


def drawable(text: str) -> str:
    r"""Return a name for matplotlib: one line, dollar signs escaped, missing glyphs as "?".

    >>> drawable("a$b$ 名")
    'a\\$b\\$ ?'
    """
    known = FT2Font(font_manager.findfont("DejaVu Sans")).get_charmap()
    plain = "".join(letter if ord(letter) in known else "?" for letter in table_cell(text, LONGEST))
    return plain.replace("\\", "\\\\").replace("$", r"\$")


def _draw_scores(axes: Axes, board: Board) -> None:
    for place, row in enumerate(board.rows):
        mean, std = row.driving_score.mean, row.driving_score.std
        if not math.isnan(std):
            axes.plot([mean - std, mean + std], [place, place], color=GREY, linewidth=1.5)
        axes.plot(mean, place, "o", color=INK, markersize=5)
    axes.set_xlim(0.0, 100.0)
    axes.set_xlabel("DS (mean ± std over repetitions)")


def _draw_differences(axes: Axes, board: Board) -> None:
    first = board.rows[0].id
    places = {row.id: place for place, row in enumerate(board.rows)}
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    for item in board.differences:
        if first in (item.better, item.worse):
            _draw_difference(axes, item, places, sign=-1.0 if item.better == first else 1.0)
    axes.set_xlabel(f"DS against {drawable(board.rows[0].planner)} (95 % interval)")


def _draw_difference(axes: Axes, item: Difference, places: dict[str, int], *, sign: float) -> None:
    """Draw a difference from the first row; hollow if it is not significant."""
    place = places[item.worse if sign < 0.0 else item.better]
    significant = item.significant
    colour = GREY if not significant else BAD if sign < 0.0 else GOOD
    paired = item.paired
    if not math.isnan(paired.low):
        ends = [sign * paired.low, sign * paired.high]
        axes.plot(ends, [place, place], color=colour, linewidth=1.5)
    fill = colour if significant else "white"
    axes.plot(sign * paired.mean, place, "o", color=colour, markerfacecolor=fill, markersize=5)


def _save(figure: Figure, path: Path, kind: str) -> None:
    metadata = {"Date": None} if kind == "svg" else {"Software": None}
    figure.savefig(path, format=kind, dpi=200, metadata=metadata)
