"""Recordings read by other libraries, as docs/notes/learning.md documents."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from plant_bench.agent import Control
from plant_bench.data.recorder import Recorder
from plant_bench.world.scene import ActorKind, Light
from tests.builders import make_actors, make_ego, make_scene

TICKS, EVERY = 21, 10
POSES = np.array([[10.0, 1.5, 0.0], [20.0, -2.0, 3.0]], np.float32)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Three frames of two actors, a response at every second tick, perturbed from tick 10 on."""
    actors = make_actors(
        POSES,
        speeds=(8.0, 1.5),
        extents=[(4.5, 1.8), (0.5, 0.5)],
        kinds=(ActorKind.CAR, ActorKind.PEDESTRIAN),
        ids=(4, 500_002),
    )
    path = tmp_path / "episode.parquet"
    recorder = Recorder(path, {"route": "town01-long-0"}, every=EVERY)
    for tick in range(TICKS):
        ego = make_ego(10.0, x=0.5 * tick, y=2.0, yaw=0.1)
        scene = make_scene(tick, ego=ego, actors=actors, lights=[Light.RED])
        answer = None if tick % 2 else Control(0.25 * tick, 0.0)
        recorder.add(scene, answer, disturbed=tick >= 10)
    recorder.close()
    return path


def check(columns: dict[str, list]) -> None:
    """Check what a reader gives as lists, null as None."""
    whole = [tick for tick, ids in enumerate(columns["actor_id"]) if ids is not None]
    assert columns["tick"] == list(range(TICKS))
    assert columns["x"] == [0.5 * tick for tick in range(TICKS)]
    assert whole == [0, 10, 20]
    assert list(columns["actor_id"][10]) == [4, 500_002]
    assert list(columns["actor_x"][20]) == POSES[:, 0].tolist()
    assert list(columns["actor_kind"][0]) == [0, 6]
    assert list(columns["lights"][0]) == [3]
    assert columns["acceleration_asked"][20] == 5.0
    assert [bool(mark) for mark in columns["disturbed"]] == [False] * 10 + [True] * 11


def test_pandas_reads_a_recording(file: Path) -> None:
    frame = pd.read_parquet(file)
    check({str(name): list(column) for name, column in frame.items()})
    one_a_row = frame.loc[::EVERY].explode(["actor_id", "actor_x", "actor_y"])
    assert len(one_a_row) == 6
    assert np.isnan(frame["acceleration_asked"][1])


def test_polars_reads_a_recording(file: Path) -> None:
    polars = pytest.importorskip("polars")
    frame = polars.read_parquet(file)
    check(frame.to_dict(as_series=False))
    assert len(frame.drop_nulls("actor_id").explode("actor_id", "actor_x", "actor_y")) == 6
    assert frame["acceleration_asked"][1] is None


def test_duckdb_reads_a_recording(file: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    with duckdb.connect() as base:
        answer = base.execute("select * from read_parquet(?) order by tick", [str(file)])
        names = [column[0] for column in answer.description]
        check(dict(zip(names, map(list, zip(*answer.fetchall(), strict=True)), strict=True)))
        query = "select count(*) from (select unnest(actor_x) from read_parquet(?))"
        assert base.execute(query, [str(file)]).fetchall() == [(6,)]


def test_metadata_is_json_under_one_key(file: Path) -> None:
    metadata = json.loads(pq.read_schema(file).metadata[b"plant_bench.metadata"])
    assert metadata == {"route": "town01-long-0"}
