import json

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.leaderboard.score_sources import find_sources, read_ranking, read_run


def add_ranking(path, agent):
    spread = {"mean": 97.0, "std": None}
    facts = {"agent": agent, "protocol": "longest6-sumo-v2-rc2", "penalties": "lb1.0"}
    numbers = {"score": spread, "filtered": spread, "whole": spread}
    counts = {"repetitions": [97.0], "episodes": 12, "unmatched": 0}
    (path / "rfds.json").write_text(json.dumps(facts | numbers | counts), encoding="utf-8")


def test_all_runs_below_the_folder_are_found_by_default(tmp_path, write_run):
    write_run(tmp_path / "a")
    write_run(tmp_path / "rfds" / "attention")
    add_ranking(tmp_path / "rfds" / "attention", "expert-filtered@attention:plant")
    (tmp_path / "leaderboard").mkdir()
    found = find_sources([], below=tmp_path)
    assert [path.name for path in found.runs] == ["a"]
    assert [path.name for path in found.rankings] == ["attention"]


def test_run_without_episodes_is_skipped_with_a_note(tmp_path, write_run):
    write_run(tmp_path / "a")
    write_run(tmp_path / "b", routes=0)
    found = find_sources([], below=tmp_path)
    assert [path.name for path in found.runs] == ["a"]
    assert "no finished episodes" in found.notes[0]


def test_requested_run_without_episodes_is_refused(tmp_path, write_run):
    with pytest.raises(InputError, match="no finished episodes"):
        find_sources([write_run(tmp_path / "b", routes=0)], below=tmp_path)


def test_path_that_is_not_a_run_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"has no run\.json"):
        find_sources([tmp_path], below=tmp_path)
    with pytest.raises(InputError, match="does not exist"):
        find_sources([tmp_path / "gone"], below=tmp_path)


@pytest.mark.parametrize("name", ["leaderboard.html", "replay.html", "losses.csv", "ablations.md"])
def test_other_folders_of_plant_bench_are_left_out_with_a_note(tmp_path, write_run, name):
    run, other = write_run(tmp_path / "a"), tmp_path / "other"
    other.mkdir()
    (other / name).touch()
    (tmp_path / "README.md").touch()

    found = find_sources([run, other, tmp_path / "README.md"], below=tmp_path)

    assert found.runs == (run,)
    assert [note.split()[0] for note in found.notes] == [str(other), str(tmp_path / "README.md")]
    with pytest.raises(InputError, match=r"has no run\.json"):
        find_sources([other], below=tmp_path)
    with pytest.raises(InputError, match="No run of 'plant-bench score' was given"):
        find_sources([other, tmp_path / "README.md"], below=tmp_path)


def test_report_without_any_run_is_refused(tmp_path):
    with pytest.raises(InputError, match="Score a planner first"):
        find_sources([], below=tmp_path)


def test_episodes_know_if_they_have_a_recording(tmp_path, write_run):
    assert all(
        item.recording for item in read_run(write_run(tmp_path / "a", recorded=True)).episodes
    )
    assert not any(item.recording for item in read_run(write_run(tmp_path / "b")).episodes)


def test_rfds_run_names_its_ranker_and_planner(tmp_path, write_run):
    path = write_run(tmp_path / "x")
    add_ranking(path, "expert-filtered@attention:plant@models/mine")
    found = read_ranking(path)
    assert (found.ranker, found.planner) == ("attention", "plant@models/mine")
    add_ranking(path, "expert-filtered@distance")
    assert read_ranking(path).planner is None


def test_broken_rfds_file_is_refused(tmp_path, write_run):
    path = write_run(tmp_path / "x")
    (path / "rfds.json").write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match=r"rfds\.json"):
        read_ranking(path)


@pytest.mark.parametrize("name", ["seed", "format"])
def test_record_with_an_oversized_number_is_refused(tmp_path, write_run, name):
    run = write_run(tmp_path / "a")
    record = next((run / "episodes").glob("*.json"))
    record.write_text(json.dumps(json.loads(record.read_text()) | {name: 10**30}))

    with pytest.raises(InputError, match="seed or format too large"):
        read_run(run)
