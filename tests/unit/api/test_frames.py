"""Collected data as frames, for one's own training code."""

import importlib
import shutil
from pathlib import Path

import numpy as np
import pytest

import plant_bench as pb
from plant_bench.agents.loading.registry import load_agent
from plant_bench.api.planner_project import Kind, write_project
from plant_bench.training.frame_store import load_frames
from tests.builders import suite_route
from tests.unit.training.conftest import scene_of, write_recording, write_routes


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """An episode along a straight line, on a route of the benchmark."""
    folder, route = tmp_path / "data", suite_route("town01-0")
    write_routes(folder / "routes", [route])
    write_recording(
        folder / "episodes" / "a.parquet", route, answers=lambda _: pb.Control(0.5, 0.1)
    )
    return folder


def test_frames_hold_observation_action_waypoints_route_and_town(data: Path) -> None:
    frames = list(pb.frames(data))

    assert len(frames) == len(load_frames([data])) > 10
    first = frames[0]
    assert first.observation.ego == scene_of(round(first.observation.time * 20)).ego
    assert first.observation.actors is not None
    assert len(first.observation.actors) == 1
    assert first.observation.privileged is None
    assert first.answer == pb.Control(0.5, 0.1)
    np.testing.assert_allclose(first.waypoints, [[4, 0], [8, 0], [12, 0], [16, 0]], atol=1e-4)
    assert (first.route.id, first.town.name) == ("town01-0", "town01")


def test_frames_are_a_sequence(data: Path) -> None:
    frames = pb.frames(str(data), inputs=["route"])

    assert frames[0].observation.actors is None
    assert frames[-1].observation.time == frames[len(frames) - 1].observation.time
    assert [frame.observation.time for frame in frames[:3]] == [2.5, 3.0, 3.5]
    with pytest.raises(IndexError):
        _ = frames[len(frames)]


def test_inputs_that_recordings_lack_are_refused(data: Path) -> None:
    with pytest.raises(pb.InputError, match="privileged cannot be computed from recordings"):
        pb.frames(data, inputs={"route", "privileged"})


def test_incomplete_data_is_refused(data: Path) -> None:
    (data / "records").mkdir()
    (data / "records" / "gone.json").write_text('{"left_out": ""}')

    with pytest.raises(pb.InputError, match="is missing: gone"):
        pb.frames(data)
    shutil.rmtree(data / "records")
    assert pb.frames(data)


def test_training_of_the_torch_project_fits_the_speed_to_the_data(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    project = write_project("my_trained_network", tmp_path, Kind.TORCH)
    monkeypatch.syspath_prepend(str(project.folder))
    training = importlib.import_module("my_trained_network.train")
    before = training.WEIGHTS.read_bytes() if training.WEIGHTS.exists() else b""

    training.train(str(data), epochs=120)

    first, middle, last = (float(line.split()[-2]) for line in capsys.readouterr().out.splitlines())
    assert last <= middle < 0.9 * first
    assert training.WEIGHTS.read_bytes() != before
    planner = load_agent(project.spec)
    planner.reset(pb.frames(data)[0].route)
    assert isinstance(planner.act(pb.frames(data)[0].observation), pb.Plan | pb.Control)
