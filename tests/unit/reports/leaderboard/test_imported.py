import json

import pytest

from plant_bench.reports.carla_checkpoint import ImportedRecord, ImportedRun
from plant_bench.reports.carla_checkpoint_writing import checkpoint, write_checkpoint
from plant_bench.reports.leaderboard.board import CARLA, HERE
from plant_bench.reports.leaderboard.imported_checkpoints import imported_row
from plant_bench.reports.leaderboard.score_sources import read_run


def record(route, repetition, km, hits, score):
    return ImportedRecord(
        route=route,
        repetition=repetition,
        town="Town01",
        status="Completed",
        driving_score=score,
        route_completion=100.0,
        infraction_score=score / 100.0,
        counts={"collisions_vehicle": hits, "stop_infraction": 1},
        outside_km=0.0,
        route_km=km,
        km=km,
        duration=100.0,
        wall=10.0,
    )


def test_rates_are_total_counts_per_total_kilometres(tmp_path):
    """Summing or averaging per-route rates would give short routes the weight of long ones."""
    records = (record("a", 0, 1.0, 1, 60.0), record("b", 0, 9.0, 1, 80.0))
    line = imported_row(
        ImportedRun("x", "carla-lb1.0", tmp_path / "x.json", 2, records), id="x", planner="x"
    )
    assert line.driving_score.mean == pytest.approx(70.0)
    assert line.score("vehicle_collisions").mean == pytest.approx(0.2)
    assert line.rates["collision_vehicle"] == pytest.approx(0.2)
    assert line.rates["stop_infraction"] == pytest.approx(0.2)


def test_standard_deviation_is_over_repetitions(tmp_path):
    records = tuple(record("a", n, 1.0, n, 60.0 + 10.0 * n) for n in range(3))
    run = ImportedRun("x", "carla-lb1.0", tmp_path / "x.json", 3, records)
    line = imported_row(run, id="x", planner="x")
    assert (line.repetitions, line.driving_score.std) == (3, pytest.approx(10.0))


def test_checkpoint_file_is_on_a_board_of_its_own(tmp_path, write_run, leaderboard):
    run = write_run(tmp_path / "a", "a")
    results = [item for item in read_run(run).results if item.repetition == 0]
    numbers = {item.route: number for number, item in enumerate(results)}
    made = checkpoint(results, numbers=numbers, expected=len(results), walls={})
    content = json.loads(json.dumps(made))
    own, foreign = tmp_path / "own.json", tmp_path / "foreign.json"
    write_checkpoint(content, own)
    for item in content["_checkpoint"]["records"]:
        del item["plant_bench"]
    write_checkpoint(content, foreign)
    boards = leaderboard([run, foreign, own]).boards
    assert len(boards) == 3
    worlds = {board.world: board for board in boards[1:]}
    assert worlds[CARLA].protocol == "carla-lb1.0"
    assert worlds[CARLA].rows[0].planner == "foreign"
    assert worlds[HERE].rows[0].planner == "a"
    assert worlds[HERE].rows[0].driving_score.mean == pytest.approx(
        sum(item.driving_score for item in results) / len(results)
    )
