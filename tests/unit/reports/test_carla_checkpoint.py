"""Checkpoint files of CARLA: correct figures from valid ones, one error from broken ones."""

import gzip
import json
from pathlib import Path
from typing import Any

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint import load_checkpoint
from plant_bench.reports.carla_checkpoint_writing import checkpoint
from tests.unit.reports.checkpoint_files import carla_file, carla_record, episode, written

HIT = "Agent collided with type=vehicle.x and id=3 at (x=1.0, y=2.0, z=0.1)"
OUTSIDE = "Agent was off its lanes for about 15.5 meters (1.2% of the completed route)"


def test_rates_are_recomputed_from_total_counts_and_kilometres(tmp_path: Path):
    one = carla_record("RouteScenario_0", collisions_vehicle=[HIT, HIT])
    other = carla_record("RouteScenario_1", outside_route_lanes=[OUTSIDE], stop_infraction=["x"])

    run = load_checkpoint(written(tmp_path, carla_file([one, other])))

    assert (run.name, run.protocol, run.expected) == ("expert", "carla-lb1.0", 2)
    assert run.results == ()
    assert run.km == pytest.approx(1.5)
    rates = run.infractions_per_km
    assert rates["collisions_vehicle"] == pytest.approx(2 / 1.5)
    assert rates["outside_route_lanes"] == pytest.approx(0.0155 / 1.5)
    assert rates["stop_infraction"] == pytest.approx(1 / 1.5)
    first = run.records[0]
    assert (first.driving_score, first.route_completion, first.infraction_score) == (45, 75, 0.6)
    assert (first.duration, first.wall) == (100.5, 300.25)
    assert first.counts["collisions_vehicle"] == 2


def test_compressed_files_are_read_as_their_content(tmp_path: Path):
    content = carla_file([carla_record("RouteScenario_0", collisions_vehicle=[HIT])])
    packed = tmp_path / "results.json.gz"
    packed.write_bytes(gzip.compress(json.dumps(content).encode(), mtime=0))

    run = load_checkpoint(packed)

    assert run.records == load_checkpoint(written(tmp_path, content)).records
    assert run.records[0].counts["collisions_vehicle"] == 1


def test_repetitions_are_counted_if_the_route_id_lacks_them(tmp_path: Path):
    ids = ["RouteScenario_4", "RouteScenario_5", "RouteScenario_4"]

    run = load_checkpoint(written(tmp_path, carla_file([carla_record(name) for name in ids])))

    assert [(item.route, item.repetition) for item in run.records] == [
        ("RouteScenario_4", 0), ("RouteScenario_5", 0), ("RouteScenario_4", 1),
    ]  # fmt: skip


def test_leaderboard_2_files_are_another_protocol(tmp_path: Path):
    more = {"min_speed_infractions": ["slow"], "scenario_timeouts": []}
    record = carla_record("RouteScenario_7_rep2", **more) | {"num_infractions": 1}

    run = load_checkpoint(written(tmp_path, carla_file([record], labels=15)))

    assert run.protocol == "carla-lb2"
    assert (run.records[0].route, run.records[0].repetition) == ("RouteScenario_7", 2)
    assert run.infractions_per_km["min_speed_infractions"] == pytest.approx(1 / 0.75)


def test_files_of_bench2drive_and_forks_are_read(tmp_path: Path):
    more = {"scenario_name": "Accident_1", "weather_id": 3, "town_name": "Town12", "save_name": "s"}
    record = carla_record("RouteScenario_7_rep0") | more

    run = load_checkpoint(written(tmp_path, carla_file([record | {"timestamp": "now"}])))

    assert (run.protocol, run.records[0].town) == ("carla-bench2drive", "Town12")


def bad(**changes: Any) -> dict[str, Any]:
    """A file whose only record is changed."""
    return carla_file([carla_record("RouteScenario_0") | changes])


SCORES = {"score_composed": 45.0, "score_penalty": 0.6, "score_route": 75.0}
META = {"duration_game": 1.0, "duration_system": 1.0, "route_length": 1000.0}
TWICE = [carla_record("RouteScenario_0_rep0")] * 2
BROKEN: dict[str, tuple[object, str]] = {
    "empty": ("", "Expecting value"),
    "truncated": ('{"_checkpoint": {"records": [', "Expecting value"),
    "a list": ([1, 2], "valid dictionary"),
    "no records": (carla_file([]), "no records"),
    "not a number": ('{"_checkpoint": NaN}', "NaN is not a valid number"),
    "too deep": ("[" * 200_000, "nested too deeply"),
    "a key twice": ('{"labels": [], "labels": []}', "'labels' occurs twice"),
    "half a character": (bad(status="\ud800"), "surrogates"),
    "overflow": ('{"_checkpoint": {"progress": [1e999], "records": []}}', "progress.0"),
    "a long number": ('{"labels": ' + "9" * 5000 + "}", "digit"),
    "records of text": (carla_file(["x"]), "_checkpoint.records.0"),  # pyright: ignore[reportArgumentType]
    "text for a score": (bad(scores=SCORES | {"score_route": "75"}), "score_route"),
    "a score too high": (bad(scores=SCORES | {"score_penalty": 7.0}), "score_penalty"),
    "a score that is none": (bad(scores=SCORES | {"score_composed": 99.0}), "not RC x IS"),
    "no length": (bad(meta={"duration_game": 1.0}), "route_length"),
    "a negative length": (bad(meta=META | {"route_length": -1.0}), "route_length"),
    "infractions that are numbers": (bad(infractions={"red_light": 3}), "red_light"),
    "infractions that lack": (bad(infractions={}), "lack collisions_layout"),
    "outside, but how far": (
        carla_file([carla_record("a", outside_route_lanes=["far"])]), "found no number",
    ),
    "an episode twice": (carla_file(TWICE), "occurs 2 times"),
    "a billion episodes": ('{"_checkpoint": {"progress": [0, 1000000000], "records": []}}', "1000"),
    "our part is broken": (bad(plant_bench={"result": {"agent": 3}}), "plant_bench.result"),
    "our part is no object": (bad(plant_bench="<script>"), "plant_bench"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken_checkpoint_file_gives_one_line(name: str, tmp_path: Path):
    content, words = BROKEN[name]

    with pytest.raises(InputError) as raised:
        load_checkpoint(written(tmp_path, content))

    message = str(raised.value)
    assert words in message
    assert "\n" not in message
    assert len(message) < 600


def test_path_that_is_not_a_file_gives_one_line(tmp_path: Path):
    for path in (tmp_path, tmp_path / "absent.json"):
        with pytest.raises(InputError, match="Not a checkpoint"):
            load_checkpoint(path)
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00PAR1")
    with pytest.raises(InputError, match="Not a checkpoint"):
        load_checkpoint(tmp_path / "bytes.json")


def test_long_untrusted_names_are_kept_and_truncated_in_messages(tmp_path: Path):
    name = "<script>alert(1)</script>\U0001f697" * 400

    kept = load_checkpoint(written(tmp_path, bad(route_id=name, town_name=name)))
    with pytest.raises(InputError) as raised:
        load_checkpoint(written(tmp_path, bad(infractions={name: 3})))

    assert (kept.records[0].route, kept.records[0].town) == (name, name)
    assert len(str(raised.value)) < 600


def test_exported_file_with_changed_scores_is_refused(tmp_path: Path):
    content: Any = checkpoint([episode()], numbers={"town01-0": 0}, expected=1, walls={})
    record = content["_checkpoint"]["records"][0]
    record["scores"] = {"score_composed": 50.0, "score_penalty": 1.0, "score_route": 50.0}

    with pytest.raises(InputError, match="differ from those of its plant-bench record"):
        load_checkpoint(written(tmp_path, content))


def test_file_with_plant_bench_and_carla_records_is_refused(tmp_path: Path):
    content: Any = checkpoint([episode()], numbers={"town01-0": 0}, expected=1, walls={})
    content["_checkpoint"]["records"].append(carla_record("RouteScenario_9"))

    with pytest.raises(InputError, match="some are not"):
        load_checkpoint(written(tmp_path, content))
