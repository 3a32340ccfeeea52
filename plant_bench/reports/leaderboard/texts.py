"""A leaderboard as Markdown and as LaTeX; names from outside are escaped."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from plant_bench.reports.leaderboard.board import HERE, Board, Difference, Leaderboard
from plant_bench.reports.leaderboard.lines import Line
from plant_bench.scoring.metrics import Spread

LONGEST = 60  # characters of a name in a table
LEVEL = 0.05  # of a corrected p-value
_NO_TEXT = {"\u200b", "\u2028", "\u2029", "\ufeff"}
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
    "[": "{[}",  # an optional argument of the row's end before it, otherwise
    "]": "{]}",
    "*": "{*}",
}


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


def one_line(text: str, longest: int = LONGEST) -> str:
    r"""Return text from outside as one line of printable characters, cut where it is longer.

    >>> one_line("a\nb" + "c" * 9, longest=6)
    'a bcc…'
    """
    plain = "".join(letter if letter.isprintable() else " " for letter in text)
    plain = " ".join("".join(letter for letter in plain if letter not in _NO_TEXT).split())
    return plain if len(plain) <= longest else f"{plain[: longest - 1]}…"


def markdown_escaped(text: str) -> str:
    r"""Return text that Markdown shows as it is, in a table too.

    >>> markdown_escaped("a|b<script>")
    'a\\|b&lt;script&gt;'
    """
    plain = one_line(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"([\\`*_{}\[\]!|~$@])", r"\\\1", plain)


def latex_escaped(text: str) -> str:
    r"""Return text that every LaTeX compiles; characters beyond Latin-1 are named by their number.

    >>> latex_escaped("plant_100%"), latex_escaped("ok 😀")
    ('plant\\_100\\%', 'ok {[}U+1F600{]}')
    """
    return "".join(_LATEX.get(letter, _compiling(letter)) for letter in one_line(text))


def markdown_text(leaderboard: Leaderboard) -> str:
    """Return all boards as Markdown."""
    parts = ["# Leaderboard", "", _LEGEND, ""]
    for board in leaderboard.boards:
        parts += [f"## {markdown_escaped(board_title(board))}", ""]
        if board.source:
            parts += [f"Source: {markdown_escaped_long(board.source)}.", ""]
        heads = ["planner", "track", "inputs", *_heads(), "parameters", "episodes"]
        parts += [_row(heads), "|---|---|---|" + "---:|" * (len(heads) - 3)]
        parts += [_row(_markdown_cells(line)) for line in board.lines]
        parts += ["", *_markdown_differences(board)]
    return "\n".join(parts).rstrip() + "\n"


def latex_text(leaderboard: Leaderboard) -> str:
    """Return all boards as LaTeX tables, to be read in by a document that uses booktabs."""
    parts = [r"% Needs \usepackage{booktabs} and \usepackage[T1]{fontenc}.", ""]
    for board in leaderboard.boards:
        best = [_best(column, board.lines) for column in COLUMNS]
        heads = ["Method", "Input", *(_latex_head(column) for column in COLUMNS)]
        parts += [
            r"\begin{table}[t]",
            r"  \centering\small",
            rf"  \begin{{tabular}}{{ll{'r' * len(COLUMNS)}}}",
            r"    \toprule",
            f"    {' & '.join(heads)} \\\\",
            r"    \midrule",
            *(f"    {' & '.join(_latex_cells(line, best))} \\\\" for line in board.lines),
            r"    \bottomrule",
            r"  \end{tabular}",
            rf"  \caption{{{latex_escaped_long(_caption(board))}}}",
            r"\end{table}",
            "",
        ]
    return "\n".join(parts)


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


def markdown_escaped_long(text: str) -> str:
    """As `markdown_escaped`, of our own text that must not be cut."""
    return " ".join(markdown_escaped(word) for word in text.split())


def latex_escaped_long(text: str) -> str:
    """As `latex_escaped`, of text that must not be cut as a whole; its words are."""
    return " ".join(latex_escaped(word) for word in text.split())


_LEGEND = (
    "DS driving score (0 to 100), RC route completion (%), IS infraction score, CV collisions with "
    "vehicles per km, IT one forward pass (ms), RFDS relative filtered driving score (%): mean ± "
    "standard deviation over repetitions. Tables of different rules cannot be compared."
)


def _heads() -> list[str]:
    return [column.head for column in COLUMNS]


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _markdown_cells(line: Line) -> list[str]:
    count = f"{line.episodes}/{line.expected}" if line.expected else "-"
    parameters = "-" if line.parameters is None else f"{line.parameters / 1e6:.2f} M"
    return [
        markdown_escaped(line.planner),
        line.track or "-",
        markdown_escaped(" + ".join(line.inputs)) or "-",
        *(spread_text(column.value(line), column.digits) for column in COLUMNS),
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


def p_text(p: float) -> str:
    """Return a p-value as text.

    >>> p_text(0.0004), p_text(0.0421)
    ('< 0.001', '0.042')
    """
    if math.isnan(p):
        return "-"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def _best(column: Column, lines: Sequence[Line]) -> float:
    values = [value for line in lines if not math.isnan(value := column.value(line).mean)]
    if not values or column.highest is None:
        return math.nan
    return max(values) if column.highest else min(values)


def _latex_head(column: Column) -> str:
    arrow = {True: r" $\uparrow$", False: r" $\downarrow$", None: ""}[column.highest]
    return rf"\multicolumn{{1}}{{c}}{{\textbf{{{column.head}}}{arrow}}}"


def _latex_cells(line: Line, best: Sequence[float]) -> list[str]:
    inputs = " + ".join(line.inputs) or "-"
    cells = [latex_escaped(line.planner), latex_escaped(inputs)]
    for column, top in zip(COLUMNS, best, strict=True):
        spread = column.value(line)
        text = spread_text(spread, column.digits).replace(" ± ", r"{\scriptsize$\pm$") + "}" * (
            not math.isnan(spread.std) and not math.isnan(spread.mean)
        )
        cells.append(rf"\textbf{{{text}}}" if spread.mean == top else text)
    return cells


def _caption(board: Board) -> str:
    counts = sorted({line.repetitions for line in board.lines})
    many = str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
    text = f"{board_title(board)}. Mean and standard deviation over {many} repetitions."
    return f"{text} Source: {board.source}." if board.source else text


def _compiling(letter: str) -> str:
    """Return a character of ASCII or Latin-1 as it is, another as its number."""
    if letter == "…":
        return r"\dots{}"
    known = letter.isascii() or (letter.isalpha() and ord(letter) < 256)
    return letter if known else f"{{[}}U+{ord(letter):04X}{{]}}"
