"""A leaderboard as Markdown tables, with all names escaped."""

import math
import re
from collections.abc import Sequence

from plant_bench.reports.leaderboard.board import Board, Difference, Leaderboard
from plant_bench.reports.leaderboard.rows import Row
from plant_bench.reports.leaderboard.table_text import (
    board_title,
    columns,
    p_text,
    planner_text,
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
        parts += [_row(_markdown_cells(board, row)) for row in board.rows]
        parts += ["", *_markdown_differences(board)]
    return "\n".join(parts).rstrip() + "\n"


def markdown_escaped(text: str) -> str:
    r"""Return text that Markdown shows unchanged, also inside a table.

    >>> markdown_escaped("a|b<script>")
    'a\\|b&lt;script&gt;'
    """
    plain = table_cell(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]!|~$@])", r"\\\1", plain)


def markdown_escaped_long(text: str) -> str:
    """Escape text word by word, so that long text is not truncated."""
    return " ".join(markdown_escaped(word) for word in text.split())


def _legend() -> str:
    titles = ", ".join(f"{column.head} {column.title}" for column in columns())
    return (
        f"{titles}: mean ± standard deviation over repetitions. Tables with different rules cannot "
        "be compared."
    )


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _markdown_cells(board: Board, row: Row) -> list[str]:
    count = f"{row.episodes}/{row.expected}" if row.expected else "-"
    parameters = "-" if row.parameters is None else f"{row.parameters / 1e6:.2f} M"
    return [
        markdown_escaped(planner_text(board, row)),
        row.track or "-",
        markdown_escaped(" + ".join(row.inputs)) or "-",
        *(column.value(row).text(column.digits) for column in columns()),
        parameters,
        count,
    ]


def _markdown_differences(board: Board) -> list[str]:
    if not board.differences:
        return []
    names = {row.id: markdown_escaped(row.planner) for row in board.rows}
    heads = ["better", "worse", "DS difference", "95 % interval", "p (Holm)", "significant"]
    rows = [_row(_difference_cells(item, names)) for item in board.differences]
    note = (
        "Paired by route and seed: bootstrap interval and sign-flip test over routes, p corrected "
        "for all pairs. A difference is significant if p is at most 0.05 and the interval excludes "
        "zero."
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
        "yes" if item.significant else "no" if known else "too few routes",
    ]
