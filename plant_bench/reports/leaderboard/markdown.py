"""A leaderboard as Markdown; names from outside are escaped."""

import math
import re
from collections.abc import Sequence

from plant_bench.reports.leaderboard.board import Board, Difference, Leaderboard
from plant_bench.reports.leaderboard.rows import Line
from plant_bench.reports.leaderboard.table_text import (
    LEVEL,
    board_title,
    columns,
    p_text,
)
from plant_bench.text_escaping import table_cell


def markdown_text(leaderboard: Leaderboard) -> str:
    """Return all boards as Markdown."""
    parts = ["# Leaderboard", "", _legend(), ""]
    for board in leaderboard.boards:
        parts += [f"## {markdown_escaped(board_title(board))}", ""]
        if board.source:
            parts += [f"Source: {markdown_escaped_long(board.source)}.", ""]
        heads = [
            "planner",
            "track",
            "inputs",
            *(column.head for column in columns()),
            "parameters",
            "episodes",
        ]
        parts += [_row(heads), "|---|---|---|" + "---:|" * (len(heads) - 3)]
        parts += [_row(_markdown_cells(line)) for line in board.lines]
        parts += ["", *_markdown_differences(board)]
    return "\n".join(parts).rstrip() + "\n"


def markdown_escaped(text: str) -> str:
    r"""Return text that Markdown shows as it is, in a table too.

    >>> markdown_escaped("a|b<script>")
    'a\\|b&lt;script&gt;'
    """
    plain = table_cell(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]!|~$@])", r"\\\1", plain)


def markdown_escaped_long(text: str) -> str:
    """As `markdown_escaped`, of our own text that must not be cut."""
    return " ".join(markdown_escaped(word) for word in text.split())


def _legend() -> str:
    titles = ", ".join(f"{column.head} {column.title}" for column in columns())
    return (
        f"{titles}: mean ± standard deviation over repetitions. Tables of different rules cannot "
        "be compared."
    )


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _markdown_cells(line: Line) -> list[str]:
    count = f"{line.episodes}/{line.expected}" if line.expected else "-"
    parameters = "-" if line.parameters is None else f"{line.parameters / 1e6:.2f} M"
    return [
        markdown_escaped(line.planner),
        line.track or "-",
        markdown_escaped(" + ".join(line.inputs)) or "-",
        *(column.value(line).text(column.digits) for column in columns()),
        parameters,
        count,
    ]


def _markdown_differences(board: Board) -> list[str]:
    if not board.differences:
        return []
    names = {line.id: markdown_escaped(line.planner) for line in board.lines}
    heads = ["better", "worse", "DS difference", "95 % interval", "p (Holm)", "told apart"]
    rows = [_row(_difference_cells(item, names)) for item in board.differences]
    note = (
        "Paired by route and seed: bootstrap interval and sign-flip test over routes, p corrected "
        "for all pairs."
    )
    return [note, "", _row(heads), "|---|---|---:|---:|---:|---|", *rows, ""]


def _difference_cells(item: Difference, names: dict[str, str]) -> list[str]:
    paired = item.paired
    known = not math.isnan(paired.low)
    return [
        names[item.better],
        names[item.worse],
        f"{paired.mean:.1f}",
        f"{paired.low:.1f} to {paired.high:.1f}" if known else "-",
        p_text(item.p_corrected),
        ("yes" if item.p_corrected <= LEVEL else "no") if known else "too few routes",
    ]
