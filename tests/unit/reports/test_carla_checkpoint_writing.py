"""A run as checkpoint JSON: CARLA's parsers read it, and the round trip loses nothing."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from plant_bench.reports.carla_checkpoint import load_checkpoint
from plant_bench.reports.carla_checkpoint_run import run_checkpoint
from plant_bench.reports.carla_checkpoint_writing import checkpoint, write_checkpoint
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult
from tests.unit.reports.checkpoint_files import NINE, episode

LABELS = [
    "Avg. driving score", "Avg. route completion", "Avg. infraction penalty",
    "Collisions with pedestrians", "Collisions with vehicles", "Collisions with layout",
    "Red lights infractions", "Stop sign infractions", "Off-road infractions",
    "Route deviations", "Route timeouts", "Agent blocked",
]  # fmt: skip


def made(results: list[EpisodeResult], expected: int, folder: Path) -> dict[str, Any]:
    numbers = {"town01-0": 0, "town06-5": 35}
    content = checkpoint(results, numbers=numbers, expected=expected, walls={("town01-0", 0): 4.5})
    write_checkpoint(content, folder / "run.json")
    return json.loads((folder / "run.json").read_text())


RESULTS = [
    episode("town06-5", 0, completion=1.0, status=Status.COMPLETED, infractions=()),
    episode("town01-0", 0),
]


def parsed(document: dict[str, Any]) -> dict[str, float]:
    """Return the rates that PlanT's and TransFuser's parsers find: total counts per total km."""
    done, total = document["_checkpoint"]["progress"]
    assert done == total == len(document["_checkpoint"]["records"])
    km, counts = 0.0, dict.fromkeys(document["_checkpoint"]["global_record"]["infractions"], 0.0)
    for record in document["_checkpoint"]["records"]:
        assert record["status"] not in ("Failed", "Failed - Simulation crashed")
        assert record["route_id"].rpartition("_")[2].isdecimal()
        km += record["scores"]["score_route"] / 100.0 * record["meta"]["route_length"] / 1000.0
        for name in counts:
            messages = record["infractions"][name]
            if name == "outside_route_lanes" and messages:
                counts[name] += float(re.findall(r"\d+\.\d+", messages[0])[0]) / 1000.0
            else:
                counts[name] += len(messages)
    return {name: count / km for name, count in counts.items()}


def test_carla_parsing_rules_recover_counts_and_distances(tmp_path: Path):
    document = made(RESULTS, 2, tmp_path)

    rates = parsed(document)

    assert sorted(rates) == NINE
    assert rates["collisions_vehicle"] == pytest.approx(1 / 1.5)
    assert rates["outside_route_lanes"] == pytest.approx(0.04 * 0.51 / 1.5)
    told = document["_checkpoint"]["global_record"]["infractions"]
    assert told == pytest.approx(rates, abs=1e-6)


def test_infraction_text_has_place_type_and_id_where_parsers_look(tmp_path: Path):
    [hit] = made(RESULTS, 2, tmp_path)["_checkpoint"]["records"][0]["infractions"][
        "collisions_vehicle"
    ]

    [place] = re.findall(r"\(x=.*\)", hit)
    assert [float(item[2:]) for item in place[1:-1].split(", ")] == [1.5, -2.25, 0.0]
    assert "type=vehicle.bus and id=17 at " in hit


def test_labels_values_scores_and_meta_match_the_schema(tmp_path: Path):
    document = made(RESULTS, 2, tmp_path)

    assert document["labels"] == LABELS
    assert document["values"][:3] == ["64.400", "75.000", "0.788"]
    assert all(re.fullmatch(r"\d+\.\d{3}", value) for value in document["values"])
    first = document["_checkpoint"]["records"][0]
    assert (first["index"], first["route_id"], first["status"]) == (
        0, "RouteScenario_0", "Failed - Agent got blocked",
    )  # fmt: skip
    assert first["meta"] == {"duration_game": 99.0, "duration_system": 4.5, "route_length": 1000.0}
    scores = first["scores"]
    assert scores["score_composed"] == pytest.approx(scores["score_route"] * 0.6 * 0.96)
    assert document["_checkpoint"]["global_record"]["meta"]["exceptions"] == [
        ["RouteScenario_0", 0, "Failed - Agent got blocked"]
    ]
    assert (document["entry_status"], document["eligible"]) == ("Finished", True)


def test_unfinished_run_is_marked_as_unfinished(tmp_path: Path):
    document = made(RESULTS, 3, tmp_path)

    assert document["_checkpoint"]["progress"] == [2, 3]
    assert (document["entry_status"], document["eligible"]) == ("Started", False)
    assert load_checkpoint(tmp_path / "run.json").expected == 3


def test_agent_crashes_set_the_entry_status(tmp_path: Path):
    crashed = episode(status=Status.AGENT_CRASHED, reason="<b>\U0001f697\n" * 999, infractions=())

    document = made([crashed], 1, tmp_path)

    assert (document["entry_status"], document["eligible"]) == (
        "Finished with agent errors", False,
    )  # fmt: skip


@pytest.mark.parametrize("kind", list(InfractionKind))
def test_export_round_trip_keeps_every_kind_of_record(kind: InfractionKind, tmp_path: Path):
    share = 0.1 if kind is InfractionKind.OUTSIDE_LANES else None
    note = Infraction(kind=kind, time=1.05, x=0.1, y=0.2, progress=0.3, share=share)
    results = [
        episode(repetition=0, infractions=(note, note), completion=1 / 3),
        episode(repetition=1, agent="<script>alert(1)</script>" * 400, infractions=()),
    ]
    results[0] = results[0].model_copy(update={"agent": results[1].agent})
    made(results, 2, tmp_path)

    run = load_checkpoint(tmp_path / "run.json")

    assert list(run.results) == results
    assert (run.name, run.protocol) == (results[0].agent, "longest6-sumo-v2-rc2")
    assert [(item.route, item.repetition, item.town) for item in run.records] == [
        ("town01-0", 0, "town01"), ("town01-0", 1, "town01"),
    ]  # fmt: skip
    assert [item.wall for item in run.records] == [4.5, 0.0]


def test_failed_export_leaves_no_file(tmp_path):
    (tmp_path / "there").mkdir()
    with pytest.raises(OSError, match="there"):
        write_checkpoint({}, tmp_path / "there")
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def test_routes_imported_from_carla_keep_their_ids_and_towns(
    tmp_path: Path, write_run: Callable[..., Path]
) -> None:
    folder = RunFolder(write_run(tmp_path / "run", routes=2))
    run_file = json.loads(folder.run_file.read_text())
    first, second = run_file["routes"]
    run_file["carla_routes"] = {first: ["23", "Town04"], second: ["7", "Town01"]}
    folder.run_file.write_text(json.dumps(run_file))
    content: Any = run_checkpoint(folder).content
    records = content["_checkpoint"]["records"]
    assert {(item["route_id"], item["town_name"]) for item in records} == {
        ("RouteScenario_23", "Town04"),
        ("RouteScenario_7", "Town01"),
    }
