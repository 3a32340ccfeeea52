import json
import math

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.leaderboard.board import CARLA
from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.published import paper_rows
from plant_bench.reports.leaderboard.rows import distinct


def add_ranking(path, agent, mean, checksum=None):
    spread = {"mean": mean, "std": None}
    payload = {
        "agent": agent,
        "protocol": "longest6-sumo-v2-rc2",
        "penalties": "lb1.0",
        "score": spread,
        "filtered": spread,
        "whole": spread,
        "repetitions": [mean],
        "episodes": 12,
        "unmatched": 0,
    }
    payload |= {} if checksum is None else {"planner_checksum": checksum}
    (path / "rfds.json").write_text(json.dumps(payload), encoding="utf-8")
    return path


def test_rows_are_sorted_by_score(tmp_path, write_run, leaderboard):
    runs = [write_run(tmp_path / name, name, worse=worse) for name, worse in (("a", 1), ("b", 3))]
    (board,) = leaderboard(runs).boards
    assert [line.planner for line in board.rows] == ["b", "a"]
    assert board.rows[1].driving_score.mean == pytest.approx(60.0)
    assert [entry.row for entry in board.entries] == list(board.rows)


@pytest.mark.parametrize(
    "other",
    [{"protocol": "longest6-sumo-v0"}, {"suite": "unseen"}, {"density": "empty"}],
    ids=["protocol", "suite", "density"],
)
def test_incomparable_runs_are_on_separate_boards(tmp_path, write_run, leaderboard, other):
    runs = [write_run(tmp_path / "a", "a"), write_run(tmp_path / "b", "b", **other)]
    found = leaderboard(runs).boards
    assert [[line.planner for line in board.rows] for board in found] in (
        [["a"], ["b"]],
        [["b"], ["a"]],
    )
    assert not any(board.differences for board in found)


def test_differences_are_tested_with_corrected_p_values(tmp_path, write_run, leaderboard):
    runs = [
        write_run(tmp_path / name, name, worse=worse, routes=12)
        for name, worse in (("a", 1), ("b", 40), ("c", 40))
    ]
    (board,) = leaderboard(runs).boards
    found = {(item.better, item.worse): item for item in board.differences}
    assert len(found) == 3
    real = [item for pair, item in found.items() if pair[1] == "a"]
    assert [item.paired.mean for item in real] == pytest.approx([23 * 40.0 / 24] * 2)
    assert all(item.p_corrected <= 0.05 for item in real)
    same = next(item for pair, item in found.items() if "a" not in pair)
    assert same.p_corrected == 1.0
    assert all(item.p_corrected >= item.paired.p_value for item in found.values())


def test_two_runs_of_one_agent_are_both_shown_with_a_note(tmp_path, write_run, leaderboard):
    made = leaderboard([write_run(tmp_path / "a"), write_run(tmp_path / "b")])
    assert [line.planner for line in made.boards[0].rows] == ["scripted (a)", "scripted (b)"]
    assert len({line.id for line in made.boards[0].rows}) == 2
    assert "have the same agent" in made.notes[0]


def test_rfds_is_shown_in_the_row_of_its_planner(tmp_path, write_run, leaderboard):
    runs = [write_run(tmp_path / "a", "plant"), write_run(tmp_path / "b", "idm")]
    ranking = add_ranking(write_run(tmp_path / "r"), "expert-filtered@attention:plant", 96.5)
    random = add_ranking(write_run(tmp_path / "s"), "expert-filtered@random", 4.5)
    (board,) = leaderboard([*runs, ranking, random]).boards
    rfds = {line.planner: line.rfds.mean for line in board.rows}
    assert rfds["plant"] == 96.5
    assert math.isnan(rfds["idm"])
    assert [item.ranker for item in board.rankings] == ["attention", "random"]


def test_rfds_is_matched_by_checksum_if_known(tmp_path, write_run, leaderboard):
    runs = [write_run(tmp_path / name, "plant", checksum=name * 64) for name in "ab"]
    runs.append(write_run(tmp_path / "c", "plant@models/a", checksum="a" * 64))
    ranking = add_ranking(
        write_run(tmp_path / "r"), "expert-filtered@attention:plant", 96.5, checksum="a" * 64
    )
    made = leaderboard([*runs, ranking])
    rfds = {line.planner: line.rfds.mean for line in made.boards[0].rows}
    assert rfds["plant (a)"] == rfds["plant@models/a"] == 96.5
    assert math.isnan(rfds["plant (b)"])
    assert not any("several runs" in note for note in made.notes)


def test_rfds_of_another_checksum_is_not_matched_by_name(tmp_path, write_run, leaderboard):
    run = write_run(tmp_path / "a", "plant", checksum="a" * 64)
    ranking = add_ranking(
        write_run(tmp_path / "r"), "expert-filtered@attention:plant", 96.5, checksum="b" * 64
    )
    assert math.isnan(leaderboard([run, ranking]).boards[0].rows[0].rfds.mean)


def test_ambiguous_rfds_is_shown_in_no_row(tmp_path, write_run, leaderboard):
    runs = [write_run(tmp_path / name, "plant", checksum=name * 64) for name in "ab"]
    ranking = add_ranking(write_run(tmp_path / "r"), "expert-filtered@attention:plant", 96.5)
    made = leaderboard([*runs, ranking])
    assert not any(line.ranker for line in made.boards[0].rows)
    assert "several runs" in made.notes[0]


def test_run_with_records_of_two_agents_is_refused(tmp_path, write_run, leaderboard):
    path = write_run(tmp_path / "a", "a")
    other = write_run(tmp_path / "b", "b", routes=7)
    stray = max((other / "episodes").iterdir())
    stray.rename(path / "episodes" / stray.name)
    with pytest.raises(InputError, match="Cannot mix episodes of two agents: a"):
        leaderboard([path])


@pytest.mark.parametrize("name", ["", " ", "\u200b\n"])
def test_planner_without_a_name_is_labelled_so(tmp_path, write_run, leaderboard, name):
    assert leaderboard([write_run(tmp_path / "a", name)]).boards[0].rows[0].planner == "(no name)"


def test_a_planner_is_shown_without_folders(tmp_path, write_run, leaderboard):
    path = write_run(tmp_path / "a", "plant@/home/me/models/mine")
    assert leaderboard([path]).boards[0].rows[0].planner == "plant@mine"


def test_missing_episodes_are_shown(tmp_path, write_run, leaderboard):
    path = write_run(tmp_path / "a")
    next((path / "episodes").iterdir()).unlink()
    line = leaderboard([path]).boards[0].rows[0]
    assert (line.episodes, line.expected) == (11, 12)


def test_figures_of_the_paper_are_on_a_board_of_their_own(tmp_path, write_run, leaderboard):
    board = leaderboard([write_run(tmp_path / "a")], paper=True).boards[-1]
    assert board.world == CARLA
    assert "PlanT" in board.source
    assert {line.planner: line.driving_score.mean for line in board.rows}["PlanT"] == 81.36
    assert not board.entries


def test_figures_of_the_paper_name_their_source():
    assert all("Table 1" in line.source for line in paper_rows())


def test_equal_names_are_distinguished_by_a_word_then_a_number():
    words = ["x", "x", "y", ""]
    assert distinct(["p", "p", "p", "q"], lambda place: words[place]) == [
        "p (x) #1",
        "p (x) #2",
        "p (y)",
        "q",
    ]


def test_progress_is_reported_for_each_source(tmp_path, write_run):
    from plant_bench.reports.leaderboard.score_sources import find_sources
    from plant_bench.scoring.penalties import PenaltyScheme

    sources = find_sources([write_run(tmp_path / "a")], below=tmp_path)
    told: list[str] = []
    make_leaderboard(sources, penalties=PenaltyScheme.LB1_0, paper=False, progress=told.append)
    assert told == ["a", "differences"]
