"""A leaderboard as data frames: the columns of the CSV, JSON and Parquet exports."""

import json
from dataclasses import fields

import pandas as pd

from plant_bench.reports.leaderboard.board import Board, Difference, Entry, Leaderboard
from plant_bench.reports.leaderboard.rows import Row
from plant_bench.scoring.metrics import Spread, summary_frame
from plant_bench.scoring.metrics_table import score_metrics

_LISTS = ("infractions", "hazards")


def board_columns(board: Board) -> list[dict[str, object]]:
    """Return each row of a board as columns; unknown values are None or nan."""
    common = {
        name: getattr(board, name)
        for name in ("world", "protocol", "suite", "density", "penalties")
    }
    return [common | _row(row) for row in board.rows]


def leaderboard_frame(leaderboard: Leaderboard) -> pd.DataFrame:
    """Return the rows of all boards; `protocol`, `suite` and `density` identify the board."""
    rows = [row for board in leaderboard.boards for row in board_columns(board)]
    frame = pd.DataFrame(rows)
    frame["parameters"] = frame["parameters"].astype("Int64")
    return frame


def difference_columns(item: Difference) -> dict[str, object]:
    """Return the columns of a difference."""
    paired = item.paired
    return {
        "better": item.better,
        "worse": item.worse,
        "difference": paired.mean,
        "low": paired.low,
        "high": paired.high,
        "p_value": paired.p_value,
        "p_corrected": item.p_corrected,
        "verdict": item.verdict.value,
        "detectable": paired.detectable,
        "pairs": paired.pairs,
        "routes": paired.routes,
    }


def episode_frame(leaderboard: Leaderboard) -> pd.DataFrame:
    """Return every episode of plant-bench runs: columns of `summary.csv`, rest of the record.

    `infractions` and `hazards` hold the record's lists as JSON.
    """
    frames = [_episodes(board, entry) for board in leaderboard.boards for entry in board.entries]
    return pd.concat(frames, ignore_index=True) if frames else pd.DataFrame()


def _episodes(board: Board, entry: Entry) -> pd.DataFrame:
    order = sorted(
        entry.run.episodes,
        key=lambda item: (item.result.town, item.result.route, item.result.repetition),
    )
    frame = summary_frame([item.result for item in order], penalties=entry.summary.penalties)
    frame.insert(0, "id", entry.row.id)
    frame.insert(1, "episode", [item.name for item in order])
    frame.insert(2, "protocol", board.protocol)
    for name in ("agent_checksum", "town_checksum", "route_checksum", "format"):
        frame[name] = [getattr(item.result, name) for item in order]
    frame["completion"] = [item.result.completion for item in order]
    for name in _LISTS:
        frame[name] = [
            json.dumps([part.model_dump(mode="json") for part in getattr(item.result, name)])
            for item in order
        ]
    return frame


def _row(row: Row) -> dict[str, object]:
    columns: dict[str, object] = {}
    for item in fields(Row):
        value = getattr(row, item.name)
        if item.name == "scores":
            for metric in score_metrics():
                columns |= _spread(metric.name, row.score(metric.name))
        elif isinstance(value, Spread):
            columns |= _spread(item.name, value)
        elif item.name == "rates":
            columns |= {f"{kind}_per_km": rate for kind, rate in value.items()}
        else:
            columns[item.name] = " + ".join(value) if isinstance(value, tuple) else value
    return columns


def _spread(name: str, spread: Spread) -> dict[str, object]:
    return {f"{name}_mean": spread.mean, f"{name}_std": spread.std}
