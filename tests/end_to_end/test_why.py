"""`plant-bench why` and `export` as a user runs them, on a run with collisions."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from plant_bench.reports.carla_checkpoint import load_checkpoint
from plant_bench.runner.run.folder import RunFolder

pytestmark = pytest.mark.sumo
ROUTE = "town02-5"


def plant_bench(cwd: Path, *arguments: str, code: int = 0) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "plant_bench", *arguments],
        cwd=cwd,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("work")
    drive = ["--agent", "cruise", "--routes", ROUTE, "--repetitions", "1", "--workers", "1"]
    plant_bench(folder, "score", *drive, "--out", "run")
    return folder


def test_why_without_a_route_lists_the_infractions(work: Path):
    said = plant_bench(work, "why", "run")

    assert ROUTE in said
    assert f"plant-bench why run {ROUTE} --repetition 0" in said


def test_why_explains_and_draws_each_infraction(work: Path):
    said = plant_bench(work, "why", "run", ROUTE, "--out", "pictures", "--before", "2")

    result = RunFolder(work / "run").results()[0]
    assert result.infractions
    assert "scenes equal the recorded ones" in said
    assert said.count("2.0 s before: ") == len(result.infractions)
    assert "The expert would have braked for " in said
    pictures = sorted((work / "pictures").glob("*.png"))
    assert len(pictures) == len(result.infractions)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in pictures)


def test_unknown_route_gives_one_line_with_a_suggestion(work: Path):
    said = plant_bench(work, "why", "run", "twon02-5", code=2)

    assert said.startswith("plant-bench: There is no route 'twon02-5'")
    assert f"Did you mean {ROUTE}?" in said
    assert len(said.splitlines()) == 1


def test_run_without_infractions_is_reported_and_exits_with_0(work: Path):
    record = next((work / "run" / "episodes").glob("*.json"))
    clean = work / "clean"
    (clean / "episodes").mkdir(parents=True)
    (clean / "run.json").write_bytes((work / "run" / "run.json").read_bytes())
    told = json.loads(record.read_text()) | {"infractions": []}
    (clean / "episodes" / record.name).write_text(json.dumps(told))

    assert "no infraction" in plant_bench(work, "why", "clean", ROUTE)


def test_missing_recording_gives_one_line(work: Path):
    bare = work / "bare"
    (bare / "episodes").mkdir(parents=True)
    (bare / "run.json").write_bytes((work / "run" / "run.json").read_bytes())
    record = next((work / "run" / "episodes").glob("*.json"))
    (bare / "episodes" / record.name).write_bytes(record.read_bytes())

    assert "has no recording of" in plant_bench(work, "why", "bare", ROUTE, code=2)


def test_exported_run_is_read_back_equal(work: Path):
    said = plant_bench(work, "export", "run", "--out", "files/run.json", "--repetition", "0")

    assert "1 episode." in said
    assert list(load_checkpoint(work / "files" / "run.json").results) == (
        RunFolder(work / "run").results()
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--repetition", "7"], "no episodes of repetition 7"),
        (["--repetition", "one"], "a number from 0, or all"),
        (["--format", "csv2"], "expected carla or fcd, got 'csv2'"),
    ],
)
def test_unusable_export_gives_one_line(work: Path, arguments: list[str], words: str):
    said = plant_bench(work, "export", "run", "--out", "x.json", *arguments, code=2)

    assert words in said
    assert len(said.splitlines()) == 1
