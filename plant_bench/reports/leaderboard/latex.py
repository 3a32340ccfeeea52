"""A leaderboard as LaTeX tables (booktabs), with all names escaped."""

import math
from collections.abc import Sequence

from plant_bench.reports.leaderboard.board import Board, Leaderboard
from plant_bench.reports.leaderboard.rows import Row
from plant_bench.reports.leaderboard.table_text import (
    Column,
    board_title,
    columns,
    planner_text,
)
from plant_bench.scoring.metrics_table import Better
from plant_bench.text_escaping import table_cell

_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "`": r"\textasciigrave{}",
    '"': r"\textquotedbl{}",
    "[": "{[}",  # else read as an optional argument of the row end before it
    "]": "{]}",
    "*": "{*}",
}


_ARROWS = {Better.HIGHER: r" $\uparrow$", Better.LOWER: r" $\downarrow$", Better.NEITHER: ""}


def latex_text(leaderboard: Leaderboard) -> str:
    """Return all boards as LaTeX tables, to be included by a document that uses booktabs."""
    parts = [r"% Needs \usepackage{booktabs} and \usepackage[T1]{fontenc}.", ""]
    for board in leaderboard.boards:
        best = [_best(column, board) for column in columns()]
        heads = ["Method", "Input", *(_latex_head(column) for column in columns())]
        parts += [
            r"\begin{table}[t]",
            r"  \centering\small",
            rf"  \begin{{tabular}}{{ll{'r' * len(best)}}}",
            r"    \toprule",
            f"    {' & '.join(heads)} \\\\",
            r"    \midrule",
            *(f"    {' & '.join(_latex_cells(board, row, best))} \\\\" for row in board.rows),
            r"    \bottomrule",
            r"  \end{tabular}",
            rf"  \caption{{{latex_escaped_long(_caption(board))}}}",
            r"\end{table}",
            "",
        ]
    return "\n".join(parts)


def latex_escaped(text: str) -> str:
    r"""Return text that any LaTeX can compile; characters beyond Latin-1 become code points.

    >>> latex_escaped("plant_100%"), latex_escaped("ok 😀")
    ('plant\\_100\\%', 'ok {[}U+1F600{]}')
    """
    return "".join(_LATEX.get(letter, _compiling(letter)) for letter in table_cell(text))


def latex_escaped_long(text: str) -> str:
    """Escape text word by word, so that long text is not truncated."""
    return " ".join(latex_escaped(word) for word in text.split())


def _best(column: Column, board: Board) -> float:
    """Return the best value of the rows that drove all routes; nan if there is none."""
    complete = [row for row in board.rows if board.is_complete(row)]
    values = [value for row in complete if not math.isnan(value := column.value(row).mean)]
    if not values or column.better is Better.NEITHER:
        return math.nan
    return max(values) if column.better is Better.HIGHER else min(values)


def _latex_head(column: Column) -> str:
    arrow = _ARROWS[column.better]
    return rf"\multicolumn{{1}}{{c}}{{\textbf{{{column.head}}}{arrow}}}"


def _latex_cells(board: Board, row: Row, best: Sequence[float]) -> list[str]:
    inputs = " + ".join(row.inputs) or "-"
    cells = [latex_escaped(planner_text(board, row)), latex_escaped(inputs)]
    ranked = board.is_complete(row)
    for column, top in zip(columns(), best, strict=True):
        spread = column.value(row)
        text = spread.text(column.digits).replace(" ± ", r"{\scriptsize$\pm$") + "}" * (
            not math.isnan(spread.std) and not math.isnan(spread.mean)
        )
        cells.append(rf"\textbf{{{text}}}" if ranked and spread.mean == top else text)
    return cells


def _caption(board: Board) -> str:
    repetitions = _range([row.repetitions for row in board.rows])
    noun = "repetition" if repetitions == "1" else "repetitions"
    text = (
        f"{board_title(board)}. Mean and standard deviation over {repetitions} {noun}"
        f"{_of_some_routes(board)}."
    )
    return f"{text} Source: {board.source}." if board.source else text


def _of_some_routes(board: Board) -> str:
    """Return how many routes were driven; empty if all were, or their number is not known."""
    if all(row.routes >= row.suite_routes for row in board.rows):
        return ""
    total = max(row.suite_routes for row in board.rows)
    return f" of {_range([row.routes for row in board.rows])} of {total} routes"


def _range(counts: Sequence[int]) -> str:
    """Return the smallest and the largest count as text."""
    low, high = min(counts), max(counts)
    return str(low) if low == high else f"{low} to {high}"


def _compiling(letter: str) -> str:
    """Return an ASCII or Latin-1 character unchanged, any other as its code point."""
    if letter == "…":
        return r"\dots{}"
    known = letter.isascii() or (letter.isalpha() and ord(letter) < 256)
    return letter if known else f"{{[}}U+{ord(letter):04X}{{]}}"
