"""The checkpoint of a run folder: expected and unfinished episodes."""

from pathlib import Path

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.carla_checkpoint_run import run_checkpoint
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.results import EpisodeResult
from tests.unit.reports.checkpoint_files import episode

ROUTES = ("town01-0", "town01-1", "town02-0")


def folder(path: Path, command: str, results: list[EpisodeResult]) -> RunFolder:
    run = RunFolder(path)
    run.create()
    told = Provenance(
        agent="plant", agent_checksum="c0ffee", suite="longest6", seed=0, density="dense",
        hazards=True, protocol="longest6-sumo-v2-rc2", towns={}, routes=dict.fromkeys(ROUTES, "aa"),
        repetitions=2, command=command, versions={}, processor="",
    )  # fmt: skip
    run.write("run.json", told.model_dump_json())
    for item in results:
        run.save(f"{item.route}_r{item.repetition}_c0ffee", item, None)
    return run


RESULTS = [episode("town01-0", 0), episode("town02-0", 0), episode("town02-0", 1)]


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("plant-bench score --agent plant --repetitions 2", 6),
        ("plant-bench score --agent plant --routes 0,2 --repetitions 2", 4),
        ("plant-bench score --agent plant --routes=town02-0 --repetitions 2", 3),
    ],
)
def test_expected_episodes_follow_from_the_last_command(
    command: str, expected: int, tmp_path: Path
):
    made = run_checkpoint(folder(tmp_path, command, RESULTS))

    assert (made.episodes, made.expected) == (3, expected)


def test_routes_are_numbered_by_their_position_in_the_suite(tmp_path: Path):
    made = run_checkpoint(folder(tmp_path, "plant-bench score", RESULTS))

    checkpoint = made.content["_checkpoint"]
    assert isinstance(checkpoint, dict)
    assert [item["route_id"] for item in checkpoint["records"]] == [
        "RouteScenario_0", "RouteScenario_2", "RouteScenario_2",
    ]  # fmt: skip


def test_single_repetition_is_exported_and_a_missing_one_refused(tmp_path: Path):
    run = folder(tmp_path, "plant-bench score", RESULTS)

    assert (run_checkpoint(run, 1).episodes, run_checkpoint(run, 1).expected) == (1, 3)
    with pytest.raises(InputError, match="no episodes of repetition 2"):
        run_checkpoint(run, 2)
