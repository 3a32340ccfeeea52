import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.agent_check import same_action
from plant_bench.data import recording_file
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.data.recording_file import FORMAT_KEY, METADATA_KEY, REASON_COLUMNS
from plant_bench.errors import InputError
from plant_bench.world.scene import ActorKind, Actors, EgoState, Scene

METADATA = {"agent": "somebody", "seed": 3, "inputs": ["route"], "share": 0.1}


def some_scenes(counts=(3, 0, 5, 1)):
    rng = np.random.default_rng(0)
    return [
        Scene(
            tick,
            EgoState(*rng.normal(scale=1e3, size=6).tolist()),
            Actors(
                rng.integers(0, 2**40, count),
                rng.normal(size=(count, 3)).astype(np.float32),
                rng.normal(size=count).astype(np.float32),
                rng.normal(size=(count, 2)).astype(np.float32),
                rng.integers(0, len(ActorKind), count).astype(np.uint8),
            ),
            rng.integers(0, 4, 2).astype(np.uint8),
        )
        for tick, count in enumerate(counts)
    ]


def write(path, scenes, actions=None):
    recorder = Recorder(path, METADATA)
    for index, scene in enumerate(scenes):
        recorder.add(scene, actions[index] if actions else None)
    recorder.close()
    return path


def assert_same(one, other):
    assert one.tick == other.tick
    assert one.ego == other.ego
    assert one.lights.dtype == other.lights.dtype
    np.testing.assert_array_equal(one.lights, other.lights)
    for name in ("ids", "poses", "speeds", "extents", "kinds"):
        left, right = getattr(one.actors, name), getattr(other.actors, name)
        assert left.dtype == right.dtype
        assert left.shape == right.shape
        np.testing.assert_array_equal(left, right)


def same(one, other):
    return one is other if None in (one, other) else same_action(one, other)


def test_scenes_are_read_back_bit_for_bit(tmp_path):
    scenes = some_scenes()
    recording = Recording.load(write(tmp_path / "episode.parquet", scenes))
    assert len(recording) == len(scenes)
    for read, written in zip(recording, scenes, strict=True):
        assert_same(read, written)
    assert_same(recording[-1], scenes[-1])
    with pytest.raises(IndexError):
        recording[len(scenes)]


def test_actions_are_read_back(tmp_path):
    plan = Plan(np.random.default_rng(0).normal(size=(4, 2)))
    actions = [Control(0.1, -0.2), plan, None, Control(0.0, 0.0)]
    recording = Recording.load(write(tmp_path / "episode.parquet", some_scenes(), actions))
    for read, written in zip(recording.actions, actions, strict=True):
        assert same(read, written)


def test_reasons_are_read_back(tmp_path):
    reasons = [Reason(Cause.FREE), None, Reason(Cause.LEADER, 2**40), Reason(Cause.CONFLICT, 0)]
    recorder = Recorder(tmp_path / "episode.parquet", METADATA)
    for scene, reason in zip(some_scenes(), reasons, strict=True):
        recorder.add(scene, Control(0.0, 0.0), reason)
    recorder.close()
    assert Recording.load(tmp_path / "episode.parquet").reasons == reasons


def test_format_1_recording_is_read_without_reasons(tmp_path):
    scenes = some_scenes()
    path = write(tmp_path / "episode.parquet", scenes)
    table = pq.ParquetFile(path).read()
    metadata = {FORMAT_KEY: "1", METADATA_KEY: table.schema.metadata[METADATA_KEY]}
    old = table.drop_columns(list(REASON_COLUMNS)).replace_schema_metadata(metadata)
    pq.write_table(old, path)
    recording = Recording.load(path)
    assert recording.reasons == [None] * len(scenes)
    assert_same(recording[2], scenes[2])


def test_metadata_is_read_back_with_the_outcome(tmp_path):
    recorder = Recorder(tmp_path / "new" / "episode.parquet", METADATA)
    recorder.close(status="Failed - Agent crashed", reason="no plan")
    assert Recording.load(tmp_path / "new" / "episode.parquet").metadata == {
        **METADATA,
        "status": "Failed - Agent crashed",
        "reason": "no plan",
    }


@pytest.mark.parametrize("counts", [(), (0,), (0, 0), (1,)])
def test_recordings_with_few_or_no_actors_are_read_back(tmp_path, counts):
    scenes = some_scenes(counts)
    recording = Recording.load(write(tmp_path / "episode.parquet", scenes))
    for read, written in zip(recording, scenes, strict=True):
        assert_same(read, written)


def test_equal_episodes_give_identical_files(tmp_path):
    actions = [Control(0.1, -0.2), Plan(np.zeros((4, 2))), None, None]
    one = write(tmp_path / "one.parquet", some_scenes(), actions).read_bytes()
    assert write(tmp_path / "other.parquet", some_scenes(), actions).read_bytes() == one


def test_no_partial_file_is_left(tmp_path):
    write(tmp_path / "episode.parquet", some_scenes())
    assert [path.name for path in tmp_path.iterdir()] == ["episode.parquet"]


def test_existing_recording_is_replaced_atomically(tmp_path):
    path = write(tmp_path / "episode.parquet", some_scenes())
    before = path.read_bytes()
    recorder = Recorder(path, METADATA)
    recorder.add(some_scenes((2,))[0])
    assert path.read_bytes() == before
    recorder.close()
    assert len(Recording.load(path)) == 1


def test_actor_arrays_are_converted_to_the_recorded_types(tmp_path):
    scene = some_scenes((2,))[0]
    given = scene.actors
    wide = Actors(
        given.ids,
        given.poses.astype(float),
        given.speeds.astype(float),
        given.extents.astype(float),
        given.kinds.astype(np.uint8),
    )
    for name in ("ids", "poses", "speeds", "extents", "kinds"):
        assert getattr(wide, name).dtype == getattr(given, name).dtype
        assert (getattr(wide, name) == getattr(given, name)).all()
    recorder = Recorder(tmp_path / "episode.parquet", METADATA)
    recorder.add(Scene(0, scene.ego, wide, scene.lights))
    recorder.close()


def test_missing_recording_raises_input_error(tmp_path):
    with pytest.raises(InputError, match=r"Not a recording: .*nowhere\.parquet"):
        Recording.load(tmp_path / "nowhere.parquet")


def test_truncated_recording_raises_input_error(tmp_path):
    path = write(tmp_path / "episode.parquet", some_scenes())
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(InputError, match="Not a recording"):
        Recording.load(path)


def test_other_parquet_file_raises_input_error(tmp_path):
    path = write(tmp_path / "episode.parquet", some_scenes())
    pq.write_table(pq.ParquetFile(path).read().replace_schema_metadata({}), path)
    with pytest.raises(InputError, match="expected format 1 or 2 or 3"):
        Recording.load(path)


def test_decompression_bomb_is_refused_before_unpacking(tmp_path, monkeypatch):
    path = write(tmp_path / "episode.parquet", some_scenes())
    table = pq.ParquetFile(path).read()
    lights = pa.array([[0] * 100_000] * len(table), table.schema.field("lights").type)
    bomb = table.set_column(table.column_names.index("lights"), "lights", lights)
    pq.write_table(bomb, path)
    assert path.stat().st_size < 20_000
    monkeypatch.setattr(recording_file, "MOST_VALUES", 300_000)

    with pytest.raises(InputError, match=r"Not a recording: .*400,\d* values"):
        Recording.load(path)
