"""Columns, titles and number formats that the Markdown, LaTeX and terminal tables share."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from plant_bench.reports.leaderboard.board import HERE, Board
from plant_bench.reports.leaderboard.rows import Row
from plant_bench.scoring.metrics import Spread
from plant_bench.scoring.metrics_table import Better, Metric, headline_metrics
from plant_bench.text_escaping import table_cell

LONGEST_MARKED = 48  # characters; the page truncates longer names, and would cut the mark off


@dataclass(frozen=True)
class Column:
    """A column of a text table.

    Attributes:
        head: Column header.
        title: Long name.
        digits: Decimals shown.
        better: Which values are better.
        value: Returns the value of a row.
    """

    head: str
    title: str
    digits: int
    better: Better
    value: Callable[[Row], Spread]


def columns() -> tuple[Column, ...]:
    """Return the columns of headline scores, inference time and RFDS."""
    return (
        *map(_column, headline_metrics()),
        Column("IT", "one forward pass (ms)", 2, Better.LOWER, _inference_time),
        Column(
            "RFDS",
            "relative filtered driving score (%)",
            1,
            Better.HIGHER,
            lambda row: row.rfds,
        ),
    )


def _column(metric: Metric) -> Column:
    return Column(
        metric.label,
        metric.long_name,
        metric.digits,
        metric.better,
        lambda row: row.score(metric.name),
    )


def _inference_time(row: Row) -> Spread:
    return Spread(row.inference_ms, math.nan)


def board_title(board: Board) -> str:
    """Return a board's title: its rules, routes and traffic, and the world if not plant-bench."""
    title = board_rules(board)
    return title if board.world == HERE else f"Another world: {title} in {board.world}"


def board_rules(board: Board) -> str:
    """Return a board's rules, routes and traffic as text."""
    words = [board.protocol]
    if board.suite and board.suite not in board.protocol:
        words.append(f"{'' if board.source else 'routes '}{board.suite}")
    if board.density and board.density != "dense":
        words.append(f"{board.density} traffic")
    if board.penalties and board.penalties != "lb1.0":
        words.append(f"penalties {board.penalties}")
    return ", ".join(words)


def planner_text(board: Board, row: Row) -> str:
    """Return a row's planner; with the number of its routes if it lacks some of the table's."""
    if board.is_complete(row):
        return row.planner
    mark = f" ({row.routes} of {board.routes} routes)"
    return table_cell(row.planner, LONGEST_MARKED - len(mark)) + mark


def p_text(p: float) -> str:
    """Return a p-value as text.

    >>> p_text(0.0004), p_text(0.0421)
    ('< 0.001', '0.042')
    """
    if math.isnan(p):
        return "-"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
