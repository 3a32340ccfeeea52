"""Tables of checkpoint files: one for each set of routes, rows that lack routes are marked."""

import gzip
import json
import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.errors import InputError
from plant_bench.reports.leaderboard.columns import leaderboard_frame
from plant_bench.reports.leaderboard.latex import latex_text
from plant_bench.reports.leaderboard.leaderboard_data import page_json
from plant_bench.reports.leaderboard.markdown import markdown_text
from plant_bench.reports.leaderboard.score_sources import find_sources
from plant_bench.reports.leaderboard.table_text import board_title
from tests.unit.reports.checkpoint_files import (
    bench2drive_record,
    merged_file,
    part_file,
    scored_record,
    written,
)

RECORDS = [bench2drive_record(3, 60.0), bench2drive_record(2, 100.0), bench2drive_record(1, 100.0)]


def long_routes(score: float = 80.0, count: int = 5) -> list[dict[str, Any]]:
    return [scored_record(route, score) for route in range(count)]


def tiny_routes(first: int = 100, count: int = 20) -> list[dict[str, Any]]:
    return [scored_record(route, 95.0, 90.0) for route in range(first, first + count)]


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    """The folder of two workers' files of one run, one of them compressed."""
    folder = tmp_path / "workers"
    folder.mkdir()
    written(folder, part_file(RECORDS[:1]), "part_0.json")
    content = json.dumps(part_file(RECORDS[1:])).encode()
    (folder / "part_1.json.gz").write_bytes(gzip.compress(content))
    return folder


@pytest.mark.parametrize(
    "given", [["mine={}/part_0.json", "mine={}/part_1.json.gz"], ["mine={}"], ["{}"]]
)
def test_parts_are_one_row_equal_to_that_of_the_merged_file(
    given: list[str], parts: Path, tmp_path: Path, leaderboard
):
    merged = written(tmp_path, merged_file(RECORDS), "merged.json")

    made = leaderboard([*(Path(item.format(parts)) for item in given), merged])

    (board,) = made.boards
    own = next(row for row in board.rows if row.planner != "merged")
    other = next(row for row in board.rows if row.planner == "merged")
    assert own.planner == ("workers" if given == ["{}"] else "mine")
    mean = pd.json_normalize(RECORDS)["scores.score_composed"].mean()
    assert own.driving_score.mean == pytest.approx(mean)
    assert (own.rates, own.km, own.episodes) == (other.rates, other.km, other.episodes)
    assert {name: spread.mean for name, spread in own.scores.items()} == {
        name: spread.mean for name, spread in other.scores.items()
    }
    assert any(
        note.startswith("merged lacks 217 of 220 episodes: DS 86.7 on those it has, 1.2 if")
        for note in made.notes
    )
    assert any("all of Bench2Drive is 220: DS 1.2 if the others" in note for note in made.notes)


def test_parts_without_a_name_are_planners_in_tables_of_their_own(parts: Path, leaderboard):
    made = leaderboard([parts / "part_0.json", parts / "part_1.json.gz"])

    assert [[row.planner for row in board.rows] for board in made.boards] == [
        ["part_1"],
        ["part_0"],
    ]
    assert [board.suite for board in made.boards] == [
        "route set 1 (2 routes, 0.2 km)", "route set 2 (1 route, 0.1 km)",
    ]  # fmt: skip
    assert any("2 different sets of routes" in note for note in made.notes)


def test_each_set_of_routes_has_a_table(tmp_path: Path, leaderboard):
    stopped = part_file(long_routes(70.0), 9, "Crashed")
    stopped["_checkpoint"]["progress"] = [2, 9]
    paths = [
        written(tmp_path, part_file(long_routes()), "long_routes.json"),
        written(tmp_path, part_file(tiny_routes()), "tiny_routes.json"),
        written(tmp_path, stopped, "stopped.json"),
    ]

    made = leaderboard(paths)

    scores = [{row.planner: row.driving_score.mean for row in board.rows} for board in made.boards]
    assert scores == [{"tiny_routes": 95.0}, {"long_routes": 80.0, "stopped": 70.0}]
    assert [board_title(board) for board in made.boards] == [
        "Another world: carla-lb1.0, route set 1 (20 routes, 1.8 km) in CARLA",
        "Another world: carla-lb1.0, route set 2 (5 routes, 7.5 km) in CARLA",
    ]
    assert not any(board.differences for board in made.boards)
    assert [(row.episodes, row.expected) for row in made.boards[1].rows] == [(5, 5), (5, 9)]
    notes = "\n".join(made.notes)
    assert "stopped.json contradicts itself: its progress says 2 of 9 routes" in notes
    assert "stopped lacks 4 of 9 episodes: DS 70.0 on those it has, 38.9 if" in notes


def test_sets_of_equal_size_have_different_titles(tmp_path: Path, leaderboard):
    paths = [
        written(tmp_path, part_file(tiny_routes(first)), f"{first}.json") for first in (0, 100)
    ]

    titles = [board_title(board) for board in leaderboard(paths).boards]

    assert len(titles) == len(set(titles)) == 2
    assert all("(20 routes, 1.8 km)" in title for title in titles)


def test_routes_with_equal_ids_and_other_lengths_are_another_set(tmp_path: Path, leaderboard):
    shorter = [scored_record(route, 80.0, 1400.0) for route in range(5)]
    paths = [
        written(tmp_path, part_file(long_routes()), "a.json"),
        written(tmp_path, part_file(shorter), "b.json"),
    ]

    assert len(leaderboard(paths).boards) == 2


def test_route_without_a_length_does_not_make_another_set(tmp_path: Path, leaderboard):
    """CARLA writes 0 metres if the agent could not be set up."""
    failed = long_routes(60.0)
    failed[2]["meta"]["route_length"] = 0.0
    paths = [
        written(tmp_path, part_file(failed), "a.json"),
        written(tmp_path, part_file(long_routes()), "b.json"),
        written(tmp_path, part_file([scored_record(2, 50.0, 1400.0)]), "c.json"),
    ]

    made = leaderboard(paths)

    assert [[row.planner for row in board.rows] for board in made.boards] == [["b", "a"], ["c"]]


@pytest.fixture
def with_subset(tmp_path: Path) -> list[Path]:
    """Files of a run on five routes, and of one with a higher score on two of them."""
    return [
        written(tmp_path, part_file(long_routes()), "whole.json"),
        written(tmp_path, part_file(long_routes(99.0, 2)), "subset.json"),
    ]


def test_run_that_lacks_routes_is_marked_last_and_never_best(with_subset: list[Path], leaderboard):
    made = leaderboard(with_subset)

    (board,) = made.boards
    assert [row.planner for row in board.rows] == ["whole", "subset"]
    assert (board.rows[1].episodes, board.rows[1].expected) == (2, 5)
    bold = [line for line in latex_text(made).splitlines() if r"\textbf{" in line and "&" in line]
    assert [line.split(" & ")[0].strip() for line in bold if "Method" not in line] == ["whole"]
    marked = "subset (2 of 5 routes)"
    assert marked in latex_text(made)
    assert marked in markdown_text(made)
    assert [line["planner"] for line in json.loads(page_json(made, replays=False))["boards"][0][
        "lines"]] == ["whole", marked]  # fmt: skip
    assert any(
        note == "subset lacks 3 of 5 episodes: DS 99.0 on those it has, 39.6 if the others count "
        "as 0."
        for note in made.notes
    )
    assert list(leaderboard_frame(made)["planner"]) == ["whole", "subset"]


def test_terminal_marks_a_run_that_lacks_routes(with_subset: list[Path], tmp_path: Path):
    done = CliRunner().invoke(
        app, ["report", *map(str, with_subset), "--no-replays", "--out", str(tmp_path / "out")]
    )

    assert done.exit_code == 0, done.output
    assert "carla-lb1.0 (CARLA): DS whole 80.0, subset (2 of 5 routes) 99.0" in done.output


def test_repetitions_do_not_hide_missing_routes(tmp_path: Path, leaderboard):
    """Two routes with three repetitions are six episodes, more than the five routes."""
    thrice = [record for _ in range(3) for record in long_routes(99.0, 2)]
    paths = [
        written(tmp_path, part_file(long_routes()), "whole.json"),
        written(tmp_path, part_file(thrice), "thrice.json"),
    ]

    made = leaderboard(paths)

    assert any(note.startswith("thrice lacks 9 of 15 episodes") for note in made.notes)


def test_long_name_of_a_run_that_lacks_routes_keeps_its_mark(tmp_path: Path, leaderboard):
    long_name = "x" * 100
    paths = [
        written(tmp_path, part_file(long_routes()), "whole.json"),
        written(tmp_path, part_file(long_routes(99.0, 2)), f"{long_name}.json"),
    ]

    text = markdown_text(leaderboard(paths))

    assert re.search(r"x+… \(2 of 5 routes\)", text)


def test_own_runs_on_different_routes_are_marked(tmp_path: Path, write_run, leaderboard):
    whole = write_run(tmp_path / "a", "whole", worse=1)
    part = write_run(tmp_path / "b", "part", worse=99)
    for record in (part / "episodes").glob("town01-*"):
        record.unlink()

    made = leaderboard([whole, part])

    (board,) = made.boards
    assert [row.planner for row in board.rows] == ["whole", "part"]
    assert board.rows[0].driving_score.mean < board.rows[1].driving_score.mean
    assert "part (3 of 6 routes)" in markdown_text(made)


def test_name_without_checkpoint_files_is_refused(tmp_path: Path):
    (tmp_path / "empty").mkdir()

    for given in (f"mine={tmp_path}/empty", f"mine={tmp_path}/gone.json", f"={tmp_path}/empty"):
        with pytest.raises(InputError, match="expected NAME=FILE or NAME=FOLDER"):
            find_sources([Path(given)], below=tmp_path)


def test_name_for_a_run_of_plant_bench_is_refused(tmp_path: Path, write_run):
    run = write_run(tmp_path / "a")

    with pytest.raises(InputError, match="is a run of plant-bench.*without 'mine='"):
        find_sources([Path(f"mine={run}")], below=tmp_path)
