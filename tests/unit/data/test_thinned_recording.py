"""Recordings as `plant-bench collect` writes them: actors only at every 10th tick."""

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from plant_bench.agent import Cause, Control, Reason
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.data.recording_file import FORMAT_KEY
from plant_bench.errors import InputError
from plant_bench.world.scene import Actors, EgoState, Scene

TICKS = 25


def some_scenes():
    rng = np.random.default_rng(0)
    return [
        Scene(
            tick,
            EgoState(*rng.normal(size=6).tolist()),
            Actors(
                np.arange(tick % 4),
                rng.normal(size=(tick % 4, 3)).astype(np.float32),
                rng.normal(size=tick % 4).astype(np.float32),
                rng.normal(size=(tick % 4, 2)).astype(np.float32),
                np.zeros(tick % 4, np.uint8),
            ),
            np.array([1, 3], np.uint8),
        )
        for tick in range(TICKS)
    ]


@pytest.fixture
def scenes():
    return some_scenes()


@pytest.fixture
def path(tmp_path, scenes):
    recorder = Recorder(tmp_path / "episode.parquet", {"route": "a"}, every=10)
    for scene in scenes:
        why = Reason(Cause.LEADER, 40 + scene.tick) if scene.tick % 2 == 0 else None
        recorder.add(scene, Control(float(scene.tick), 0.0), why, disturbed=4 <= scene.tick < 8)
    recorder.close()
    return tmp_path / "episode.parquet"


def test_thinned_recording_keeps_every_10th_scene(path, scenes):
    recording = Recording.load(path)
    assert recording.complete_rows == [0, 10, 20]
    for row in recording.complete_rows:
        read, written = recording[row], scenes[row]
        assert (read.tick, read.ego) == (written.tick, written.ego)
        np.testing.assert_array_equal(read.actors.poses, written.actors.poses)
        np.testing.assert_array_equal(read.actors.ids, written.actors.ids)
        np.testing.assert_array_equal(read.lights, written.lights)


def test_thinned_recording_keeps_ego_actions_and_marks_at_each_tick(path, scenes):
    recording = Recording.load(path)
    assert len(recording) == TICKS
    np.testing.assert_array_equal(recording.egos[:, 0], [scene.ego.x for scene in scenes])
    assert recording.actions[7] == Control(7.0, 0.0)
    assert np.flatnonzero(recording.disturbed).tolist() == [4, 5, 6, 7]


def test_thinned_recording_keeps_the_reason_of_each_decision(path):
    reasons = Recording.load(path).reasons
    assert reasons[6] == Reason(Cause.LEADER, 46)
    assert [reason is None for reason in reasons[:4]] == [False, True, False, True]


def test_reading_a_thinned_out_scene_raises_input_error(path):
    recording = Recording.load(path)
    with pytest.raises(InputError, match="Tick 7 of a thinned recording has no actors"):
        recording[7]


def test_pandas_reads_a_thinned_recording(path):
    frame = pd.read_parquet(path)
    assert frame["tick"].tolist() == list(range(TICKS))
    assert frame["actor_x"].notna().to_numpy().nonzero()[0].tolist() == [0, 10, 20]
    assert len(frame["actor_x"][10]) == 2
    assert frame["lights"][20].tolist() == [1, 3]
    assert bool(frame["x"].notna().to_numpy().all())
    assert int(frame["disturbed"].to_numpy().sum()) == 4


def test_pyarrow_reads_a_thinned_recording(path):
    table = pq.read_table(path)
    assert table["actor_kind"].null_count == TICKS - 3
    assert table.schema.metadata[FORMAT_KEY] == b"3"
    assert all(
        file.compression == "ZSTD"
        for file in (pq.ParquetFile(path).metadata.row_group(0).column(i) for i in range(5))
    )


def test_recording_without_thinning_is_unchanged(tmp_path, scenes):
    recorder = Recorder(tmp_path / "full.parquet", {})
    for scene in scenes:
        recorder.add(scene)
    recorder.close()
    recording = Recording.load(tmp_path / "full.parquet")
    assert recording.complete_rows == list(range(TICKS))
    assert not recording.disturbed.any()
    schema = pq.read_schema(tmp_path / "full.parquet")
    assert schema.metadata[FORMAT_KEY] == b"2"
    assert "disturbed" not in schema.names


def test_empty_thinned_recording_is_read(tmp_path):
    Recorder(tmp_path / "empty.parquet", {}, every=10).close()
    recording = Recording.load(tmp_path / "empty.parquet")
    assert (len(recording), recording.complete_rows) == (0, [])
