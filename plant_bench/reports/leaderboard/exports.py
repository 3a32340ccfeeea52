"""Writes a leaderboard's export files: CSV, JSON, Parquet, Markdown and LaTeX."""

import json
import math
from pathlib import Path

import pandas as pd

from plant_bench import __version__
from plant_bench.atomic_files import write_whole, write_whole_text
from plant_bench.reports.leaderboard.board import Board, Leaderboard
from plant_bench.reports.leaderboard.columns import (
    board_columns,
    difference_columns,
    episode_frame,
    leaderboard_frame,
)
from plant_bench.reports.leaderboard.latex import latex_text
from plant_bench.reports.leaderboard.markdown import markdown_text

FORMAT = 1


def write_exports(leaderboard: Leaderboard, out: Path) -> list[Path]:
    """Write all export files; return their paths.

    Raises:
        OSError: A file cannot be written.
    """
    texts = {
        "leaderboard.json": leaderboard_json(leaderboard),
        "leaderboard.md": markdown_text(leaderboard),
        "leaderboard.tex": latex_text(leaderboard),
    }
    frames = {
        "leaderboard": leaderboard_frame(leaderboard),
        "episodes": episode_frame(leaderboard),
    }
    for name, text in texts.items():
        write_whole_text(out / name, text)
    for name, frame in frames.items():
        _write_frame(frame, out / name)
    names = [*texts, *(f"{name}.{kind}" for name in frames for kind in ("csv", "parquet"))]
    return [out / name for name in names]


def leaderboard_json(leaderboard: Leaderboard) -> str:
    """Return the boards as JSON: rows as in the CSV, and the differences; null if not known."""
    boards = [_board(board) for board in leaderboard.boards]
    payload = {"format": FORMAT, "plant_bench": __version__, "boards": boards}
    return json.dumps(without_nan(payload), indent=1, ensure_ascii=False) + "\n"


def without_nan(value: object) -> object:
    """Return values for JSON, with None for floats that are not finite."""
    if isinstance(value, dict):
        return {name: without_nan(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _board(board: Board) -> dict[str, object]:
    names = ("world", "protocol", "suite", "density", "penalties", "source")
    return {
        **{name: getattr(board, name) for name in names},
        "rows": board_columns(board),
        "differences": [difference_columns(item) for item in board.differences],
    }


def _write_frame(frame: pd.DataFrame, path: Path) -> None:
    """Write a frame as CSV and as Parquet; both keep the exact values of floats."""
    text = frame.to_csv(index=False, lineterminator="\n")
    write_whole_text(path.with_name(f"{path.name}.csv"), text)
    parquet = path.with_name(f"{path.name}.parquet")
    write_whole(parquet, lambda part: frame.to_parquet(part, index=False))
