"""Recorded episodes as SUMO's floating car data."""

import gzip
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from plant_bench.agent import Control
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.reports.fcd import write_fcd
from plant_bench.world.scene import EGO_LENGTH, ActorKind, Actors, EgoState, Scene


@pytest.fixture
def recording(tmp_path: Path) -> Recording:
    """A recording of two ticks: the ego heads north, a car east, a pedestrian west."""
    path = tmp_path / "episode.parquet"
    recorder = Recorder(path, {})
    for tick in range(2):
        actors = Actors(
            ids=np.array([7, 9]),
            poses=np.array([[10.0, 5.0, 0.0], [3.0, 4.0, math.pi]], dtype=np.float32),
            speeds=np.array([6.0, 1.0], dtype=np.float32),
            extents=np.array([[4.0, 2.0], [0.5, 0.5]], dtype=np.float32),
            kinds=np.array([ActorKind.CAR, ActorKind.PEDESTRIAN], dtype=np.uint8),
        )
        ego = EgoState(x=1.0, y=2.0 + tick, yaw=math.pi / 2, speed=20.0)
        recorder.add(Scene(tick, ego, actors, np.zeros(0, dtype=np.uint8)), Control(0.0, 0.0))
    recorder.close()
    return Recording.load(path)


@pytest.mark.parametrize("name", ["a.fcd.xml", "a.fcd.xml.gz"])
def test_positions_are_front_bumpers_and_angles_are_clockwise_from_north(
    tmp_path: Path, recording: Recording, name: str
) -> None:
    assert write_fcd(recording, tmp_path / name) == 2
    content = (tmp_path / name).read_bytes()
    root = ElementTree.fromstring(gzip.decompress(content) if name.endswith(".gz") else content)
    assert [step.get("time") for step in root] == ["0.00", "0.05"]
    ego, car = root[0].findall("vehicle")
    (person,) = root[0].findall("person")
    assert (ego.get("id"), ego.get("angle")) == ("ego", "0.00")
    assert float(str(ego.get("y"))) == pytest.approx(2.0 + EGO_LENGTH / 2, abs=0.006)
    assert (car.get("x"), car.get("y"), car.get("angle"), car.get("type")) == (
        "12.00",
        "5.00",
        "90.00",
        "car",
    )
    assert (person.get("x"), person.get("angle")) == ("3.00", "270.00")
