"""Exported values, read back by pandas, equal those of the runs."""

import json
from io import StringIO

import pandas as pd
import pytest

from plant_bench.reports.leaderboard.columns import episode_frame, leaderboard_frame
from plant_bench.reports.leaderboard.exports import leaderboard_json, write_exports
from plant_bench.scoring.results import EpisodeResult

HOSTILE = 'a,"b"\n<script>alert(1)</script> 😀 =1+1'


@pytest.fixture
def written(tmp_path, write_run, leaderboard):
    runs = [
        write_run(tmp_path / "a", "a", worse=1),
        write_run(tmp_path / "b", HOSTILE, reason=HOSTILE),
        write_run(tmp_path / "c", "c", protocol="longest6-sumo-v0"),
    ]
    made = leaderboard(runs, paper=True)
    write_exports(made, tmp_path / "out")
    return made, tmp_path / "out"


def read_csv(path):
    return pd.read_csv(path, keep_default_na=False, na_values=[""])


def assert_same(read, made):
    """Assert equality except for types that CSV cannot express, such as empty text."""
    assert list(read.columns) == list(made.columns)
    for name in made.columns:
        for there, here in zip(read[name], made[name], strict=True):
            empty = here is None or here is pd.NA or here != here or here == ""  # noqa: PLR0124
            assert pd.isna(there) if empty else there == here, (name, there, here)


@pytest.mark.parametrize("name", ["leaderboard", "episodes"])
def test_csv_and_parquet_hold_identical_values(written, name):
    made, out = written
    frame = leaderboard_frame(made) if name == "leaderboard" else episode_frame(made)
    assert_same(read_csv(out / f"{name}.csv"), frame)
    parquet = pd.read_parquet(out / f"{name}.parquet")
    assert_same(parquet.replace({"": None}), frame)


def test_each_record_can_be_rebuilt_from_its_row(written):
    made, out = written
    records = {
        (entry.row.id, item.name): item.result
        for board in made.boards
        for entry in board.entries
        for item in entry.run.episodes
    }
    frame = read_csv(out / "episodes.csv")
    assert len(frame) == len(records) == 36
    for row in frame.to_dict("records"):
        record = records[row["id"], row["episode"]]
        told = {name: row[name] for name in EpisodeResult.model_fields if name in row}
        told |= {name: json.loads(row[name]) for name in ("infractions", "hazards")}
        told |= {"inputs": row["inputs"].split(), "measures": record.measures}
        told["reason"] = record.reason if pd.notna(row["reason"]) else ""
        assert EpisodeResult.model_validate(told) == record
        assert row["driving_score"] == record.driving_score
        assert row["jerk_p95"] == record.measures["jerk_p95"]


def test_leaderboard_row_equals_the_summary(written):
    made, out = written
    frame = read_csv(out / "leaderboard.csv").set_index("id")
    for board in made.boards:
        for entry in board.entries:
            row, scores = frame.loc[entry.row.id], entry.summary.scores
            assert row["driving_score_mean"] == scores["driving_score"].mean
            assert row["vehicle_collisions_std"] == scores["vehicle_collisions"].std
            assert row["planner"] == entry.row.planner


def test_json_separates_boards_and_contains_no_nan(written):
    made, out = written
    text = (out / "leaderboard.json").read_text(encoding="utf-8")
    assert text == leaderboard_json(made)

    def refuse(name):
        raise AssertionError(name)

    told = json.loads(text, parse_constant=refuse)
    assert sorted(len(board["rows"]) for board in told["boards"]) == [1, 2, 9]
    rows = pd.read_json(StringIO(json.dumps(told["boards"][1]["rows"])))
    assert len(rows) == 1
    (difference,) = next(board for board in told["boards"] if len(board["rows"]) == 2)[
        "differences"
    ]
    assert difference["pairs"] == 12


def test_no_partial_export_is_left(written):
    _, out = written
    assert not list(out.glob("*.part"))
