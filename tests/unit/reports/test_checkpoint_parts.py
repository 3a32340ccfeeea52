"""One planner's results in several files, merged files, and files that contradict themselves."""

import gzip
import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint import load_checkpoint, load_checkpoints
from tests.unit.reports.checkpoint_files import (
    bench2drive_record,
    carla_record,
    merged_file,
    part_file,
    scored_record,
    written,
)

RECORDS = [bench2drive_record(3, 60.0), bench2drive_record(2, 100.0), bench2drive_record(1, 100.0)]


def files(folder: Path, *contents: Any) -> list[Path]:
    return [written(folder, item, f"part_{number}.json") for number, item in enumerate(contents)]


def records_of(first: int, count: int) -> list[dict[str, Any]]:
    """Records of leaderboard 1.0 on consecutive routes."""
    return [scored_record(route, 80.0) for route in range(first, first + count)]


def test_merged_file_is_one_run_of_all_routes_of_bench2drive(tmp_path: Path):
    run = load_checkpoint(written(tmp_path, merged_file(RECORDS), "merged.json"))

    frame = pd.json_normalize(RECORDS)
    assert (run.name, run.protocol) == ("merged", "carla-bench2drive")
    assert (len(run.records), run.expected) == (3, 220)
    assert [item.route for item in run.records] == [
        "RouteScenario_3", "RouteScenario_2", "RouteScenario_1",
    ]  # fmt: skip
    scores = pd.Series([item.driving_score for item in run.records])
    assert scores.mean() == pytest.approx(frame["scores.score_composed"].mean())
    assert run.km == pytest.approx(frame["meta.route_length"].sum() / 1000)


def test_parts_are_the_same_run_as_the_merged_file(tmp_path: Path):
    merged = load_checkpoint(written(tmp_path, merged_file(RECORDS), "merged.json"))
    paths = files(tmp_path, part_file(RECORDS[:1]), part_file(RECORDS[1:]))

    run = load_checkpoints(paths, "mine")

    assert (run.name, run.protocol, run.expected) == ("mine", merged.protocol, 3)
    assert run.records == merged.records
    assert run.infractions_per_km == merged.infractions_per_km
    assert run.notes == ()


def test_compressed_file_is_read_and_named_without_its_endings(tmp_path: Path):
    path = tmp_path / "mine.json.gz"
    path.write_bytes(gzip.compress(json.dumps(part_file(RECORDS)).encode()))

    assert load_checkpoint(path).name == "mine"
    assert len(load_checkpoint(path).records) == 3
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(InputError, match="truncated"):
        load_checkpoint(path)


def test_merged_parts_lack_episodes_of_bench2drive_only_once(tmp_path: Path):
    paths = files(tmp_path, merged_file(RECORDS[:1]), merged_file(RECORDS[1:]))

    assert load_checkpoints(paths).expected == 220


def test_merged_file_with_two_repetitions_has_220_episodes_of_each(tmp_path: Path):
    twice = [*RECORDS, *(bench2drive_record(route, 50.0, 1) for route in (1, 2, 3))]

    assert load_checkpoint(written(tmp_path, merged_file(twice))).expected == 440


def test_merged_and_unmerged_parts_of_bench2drive_lack_episodes_once(tmp_path: Path):
    paths = files(tmp_path, merged_file(RECORDS[:1]), part_file(RECORDS[1:], 110))

    assert load_checkpoints(paths).expected == 220


@pytest.mark.parametrize(
    ("counts", "totals", "status", "expected", "words"),
    [
        ((1, 2), (1, 2), "Finished", 3, ""),  # each worker has its own routes
        ((2, 2), (2, 2), "Finished", 4, ""),
        ((1, 2), (4, 5), "Started", 9, ""),
        ((2, 1), (2, 2), "Started", 4, ""),  # one worker is finished: the total is its own
        ((3, 2), (9, 9), "Finished with missing data", 9, "9 episodes: read as 9 in all"),
        ((3, 2), (9, 9), "Started", 18, "9 episodes: read as 18 in all"),
        ((3, 2), (4, 4), "Started", 8, ""),  # more than the total: it is each worker's
    ],
)
def test_totals_of_parts_are_added_unless_they_are_those_of_the_whole_run(
    counts: tuple[int, int], totals: tuple[int, int], status: str, expected: int, words: str,
    tmp_path: Path,
):  # fmt: skip
    parts = [records_of(0, counts[0]), records_of(50, counts[1])]
    paths = files(
        tmp_path,
        *(part_file(part, total, status) for part, total in zip(parts, totals, strict=True)),
    )

    run = load_checkpoints(paths, "mine")

    assert run.expected == expected
    assert [note for note in run.notes if note.startswith("mine: ")] == (
        [f"mine: each of its 2 files says {words}."] if words else []
    )


def test_workers_that_all_say_220_routes_of_bench2drive_share_them(tmp_path: Path):
    paths = files(
        tmp_path,
        *(part_file(part, 220, "Started") for part in (RECORDS[:1], RECORDS[1:])),
    )

    assert load_checkpoints(paths).expected == 220


def test_single_file_has_the_total_of_its_progress(tmp_path: Path):
    assert load_checkpoint(written(tmp_path, part_file(RECORDS, 10, "Started"))).expected == 10


def test_files_with_a_common_episode_are_refused(tmp_path: Path):
    paths = files(tmp_path, part_file(RECORDS[:2]), part_file(RECORDS[1:]))

    with pytest.raises(InputError, match="not parts of one run .*RouteScenario_2.*part_1.json"):
        load_checkpoints(paths, "mine")


def test_files_of_different_protocols_are_refused(tmp_path: Path):
    paths = files(tmp_path, part_file(RECORDS[:1]), part_file(records_of(5, 1)))

    with pytest.raises(InputError, match="their protocols differ: part_0.json carla-bench2drive"):
        load_checkpoints(paths, "mine")


@pytest.mark.parametrize(
    ("count", "own", "words"),
    [
        (3, 260.0 / 220, "own driving score, 1.18, counts 217 missing routes as 0"),
        (3, 260.0 / 3, ""),  # no route is missing in this mean
        (3, 50.0, "own driving score, 50.00, is not the mean of its episodes, 86.67"),
        (220, 60.0, ""),
        (220, 30.0, "own driving score, 30.00, is not the mean of its episodes, 60.00"),
        (3, 0.0, "own driving score, 0.00, is not the mean of its episodes, 86.67"),
    ],
)
def test_own_score_of_a_merged_file_is_explained(
    count: int, own: float, words: str, tmp_path: Path
):
    records = RECORDS if count == 3 else [bench2drive_record(n, 60.0) for n in range(count)]
    content = merged_file(records) | {"driving score": own}

    (*notes,) = load_checkpoint(written(tmp_path, content, "merged.json")).notes

    assert len(notes) == bool(words)
    assert all(words in note for note in notes)


@pytest.mark.parametrize(
    ("progress", "status", "words"),
    [
        ([5, 5], "Finished", ""),
        ([5, 9], "Finished with missing data", ""),
        ([2, 9], "Crashed", ("contradicts itself: its progress says 2 of 9 routes, entry_status "
         "'Crashed', but it has 5 records; the others may be left over from an earlier run")),
        ([7, 9], "Started", ("progress says 7 of 9 routes, entry_status 'Started', but it has 5 "
         "records.")),
        ([5, 9], "Started", "its evaluation ended with the status 'Started'"),
        ([5, 9], "Finished", ("contradicts itself: its entry_status is 'Finished', but its "
         "progress says 5 of 9 routes")),
    ],
)  # fmt: skip
def test_contradictions_in_a_file_are_noted(
    progress: list[int], status: str, words: str, tmp_path: Path
):
    content = part_file(records_of(0, 5), status=status)
    content["_checkpoint"]["progress"] = progress

    run = load_checkpoint(written(tmp_path, content, "stopped.json"))

    assert len(run.notes) == bool(words)
    assert all(words in note for note in run.notes)
    assert run.expected == max(5, progress[1])


def test_length_of_a_route_is_known_if_one_repetition_knows_it(tmp_path: Path):
    failed = carla_record("RouteScenario_0")
    failed["meta"] |= {"route_length": 0.0}  # the agent could not be set up

    content = part_file([carla_record("RouteScenario_0"), failed])

    assert load_checkpoint(written(tmp_path, content)).route_lengths == {"RouteScenario_0": 1.0}
