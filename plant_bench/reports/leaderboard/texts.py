"""What Markdown, LaTeX and the terminal say alike: columns, titles and numbers."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from plant_bench.reports.leaderboard.board import HERE, Board
from plant_bench.reports.leaderboard.lines import Line
from plant_bench.scoring.metrics import Spread

LEVEL = 0.05  # of a corrected p-value


@dataclass(frozen=True)
class Column:
    """A column of a text table.

    Attributes:
        head: Its name.
        digits: After the point.
        value: What it tells of a line.
        highest: Whether the highest value is the best; None where none is.
    """

    head: str
    digits: int
    value: Callable[[Line], Spread]
    highest: bool | None = None


COLUMNS = (
    Column("DS", 1, lambda line: line.driving_score, highest=True),
    Column("RC", 1, lambda line: line.route_completion, highest=True),
    Column("IS", 2, lambda line: line.infraction_score, highest=True),
    Column("CV", 2, lambda line: line.vehicle_collisions, highest=False),
    Column("IT", 2, lambda line: Spread(line.inference_ms, math.nan), highest=False),
    Column("RFDS", 1, lambda line: line.rfds, highest=True),
)


def board_title(board: Board) -> str:
    """Return what a board is called: its rules, routes and traffic; another world is named."""
    words = [board.protocol]
    if board.suite and board.suite not in board.protocol:
        words.append(f"routes {board.suite}")
    if board.density and board.density != "dense":
        words.append(f"{board.density} traffic")
    if board.law and board.law != "lb1.0":
        words.append(f"law {board.law}")
    title = ", ".join(words)
    return title if board.world == HERE else f"Another world: {title} in {board.world}"


def spread_text(spread: Spread, digits: int) -> str:
    """Return mean and deviation as text, "-" where there is none.

    >>> spread_text(Spread(81.356, 6.54), 1), spread_text(Spread(math.nan, math.nan), 1)
    ('81.4 ± 6.5', '-')
    """
    if math.isnan(spread.mean):
        return "-"
    mean = f"{spread.mean:.{digits}f}"
    return mean if math.isnan(spread.std) else f"{mean} ± {spread.std:.{digits}f}"


def p_text(p: float) -> str:
    """Return a p-value as text.

    >>> p_text(0.0004), p_text(0.0421)
    ('< 0.001', '0.042')
    """
    if math.isnan(p):
        return "-"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
