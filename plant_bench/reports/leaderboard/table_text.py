"""What Markdown, LaTeX and the terminal say alike: columns, titles and numbers."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from plant_bench.reports.leaderboard.board import HERE, Board
from plant_bench.reports.leaderboard.rows import Line
from plant_bench.scoring.metrics import Spread
from plant_bench.scoring.metrics_table import Better, Metric, headline_metrics

LEVEL = 0.05  # of a corrected p-value


@dataclass(frozen=True)
class Column:
    """A column of a text table.

    Attributes:
        head: Its name.
        title: The name in full.
        digits: After the point.
        better: Which values are the better ones.
        value: What it tells of a line.
    """

    head: str
    title: str
    digits: int
    better: Better
    value: Callable[[Line], Spread]


def columns() -> tuple[Column, ...]:
    """Return the headline scores, and what is known of a planner beside its episodes."""
    return (
        *map(_column, headline_metrics()),
        Column("IT", "one forward pass (ms)", 2, Better.LOWER, _inference_time),
        Column(
            "RFDS",
            "relative filtered driving score (%)",
            1,
            Better.HIGHER,
            lambda line: line.rfds,
        ),
    )


def _column(metric: Metric) -> Column:
    return Column(
        metric.label,
        metric.full,
        metric.digits,
        metric.better,
        lambda line: line.score(metric.name),
    )


def _inference_time(line: Line) -> Spread:
    return Spread(line.inference_ms, math.nan)


def board_title(board: Board) -> str:
    """Return what a board is called: its rules, routes and traffic; another world is named."""
    words = [board.protocol]
    if board.suite and board.suite not in board.protocol:
        words.append(f"routes {board.suite}")
    if board.density and board.density != "dense":
        words.append(f"{board.density} traffic")
    if board.penalties and board.penalties != "lb1.0":
        words.append(f"penalties {board.penalties}")
    title = ", ".join(words)
    return title if board.world == HERE else f"Another world: {title} in {board.world}"


def p_text(p: float) -> str:
    """Return a p-value as text.

    >>> p_text(0.0004), p_text(0.0421)
    ('< 0.001', '0.042')
    """
    if math.isnan(p):
        return "-"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
