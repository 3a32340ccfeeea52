"""`plant-bench export`: options that do not belong to the format are refused."""

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from typer.testing import CliRunner

from plant_bench.agent import Control
from plant_bench.cli import app
from plant_bench.data.recorder import Recorder
from plant_bench.errors import InputError
from plant_bench.world.scene import Actors, EgoState, Scene


def export(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


def record(path: Path, ticks: int) -> None:
    """Write a recording of an ego alone."""
    path.unlink()
    recorder = Recorder(path, {})
    actors = Actors(
        ids=np.zeros(0, dtype=np.int64),
        poses=np.zeros((0, 3), dtype=np.float32),
        speeds=np.zeros(0, dtype=np.float32),
        extents=np.zeros((0, 2), dtype=np.float32),
        kinds=np.zeros(0, dtype=np.uint8),
    )
    for tick in range(ticks):
        ego = EgoState(x=float(tick), y=0.0, yaw=0.0, speed=20.0)
        recorder.add(Scene(tick, ego, actors, np.zeros(0, dtype=np.uint8)), Control(0.0, 0.0))
    recorder.close()


@pytest.fixture
def run(tmp_path, write_run):
    """A run with two repetitions of town01-0, recorded for 1 and 2 ticks."""
    path = write_run(tmp_path / "a", recorded=True)
    for file in (path / "recordings").glob("town01-0_*"):
        record(file, 1 + ("_r1_" in file.name))
    return path


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--route", "town01-0"], "--route town01-0: --format carla writes all routes of a run"),
        (["--format", "fcd", "--route", "0", "--repetition", "all"],
         "--repetition all: --format fcd writes one episode"),
        (["--format", "fcd"], "--format fcd writes one episode: choose it with --route"),
        (["--repetition", "9" * 5000], "expected a number from 0, or all"),
        (["--format", "fcd", "--route", "0", "--repetition", "2"], "its repetitions are 0, 1"),
    ],
)  # fmt: skip
def test_options_that_would_be_ignored_are_refused(run, tmp_path, options, told):
    done = export(run, "--out", tmp_path / "out.file", *options)

    assert isinstance(done.exception, InputError)
    assert told in str(done.exception)
    assert not (tmp_path / "out.file").exists()


@pytest.mark.parametrize(
    ("options", "ticks"), [([], 1), (["--repetition", "1"], 2), (["--repetition", "0"], 1)]
)
def test_fcd_has_the_first_or_the_chosen_repetition(run, tmp_path, options, ticks):
    out = tmp_path / "a.fcd.xml"

    done = export(run, "--format", "fcd", "--route", "town01-0", "--out", out, *options)

    assert done.exit_code == 0, done.output
    assert len(ElementTree.parse(out).getroot()) == ticks
    said = {1: "1 time step of town01-0_r0_", 2: "2 time steps of town01-0_r1_"}
    assert said[ticks] in done.output


def test_fcd_has_the_first_repetition_that_exists(run, tmp_path):
    next((run / "episodes").glob("town01-0_r0_*")).unlink()
    out = tmp_path / "a.fcd.xml"

    done = export(run, "--format", "fcd", "--route", "town01-0", "--out", out)

    assert "2 time steps of town01-0_r1_" in done.output


@pytest.mark.parametrize(("options", "count"), [([], 12), (["--repetition", "all"], 12),
                                                (["--repetition", "1"], 6)])  # fmt: skip
def test_checkpoint_has_all_or_the_chosen_repetition(run, tmp_path, options, count):
    out = tmp_path / "a.json"

    done = export(run, "--out", out, *options)

    assert done.exit_code == 0, done.output
    assert len(json.loads(out.read_text())["_checkpoint"]["records"]) == count
