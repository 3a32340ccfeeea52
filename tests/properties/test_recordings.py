import tempfile
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.agent_check import same_action
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.world.scene import Actors, EgoState, Scene

numbers = st.floats(allow_nan=False, allow_infinity=False)
singles = st.floats(allow_nan=False, allow_infinity=False, width=32)
actions = st.one_of(
    st.none(),
    st.builds(Control, numbers, numbers),
    arrays.arrays(np.float64, (4, 2), elements=numbers).map(Plan),
)
reasons = st.one_of(
    st.none(), st.builds(Reason, st.sampled_from(Cause), st.integers(-1, 2**63 - 1))
)


def same(one, other):
    return one is other if None in (one, other) else same_action(one, other)


@st.composite
def scenes(draw):
    count = draw(st.integers(0, 4))
    return Scene(
        draw(st.integers(0, 20_000)),
        EgoState(*draw(st.lists(numbers, min_size=6, max_size=6))),
        Actors(
            draw(arrays.arrays(np.int64, count)),
            draw(arrays.arrays(np.float32, (count, 3), elements=singles)),
            draw(arrays.arrays(np.float32, count, elements=singles)),
            draw(arrays.arrays(np.float32, (count, 2), elements=singles)),
            draw(arrays.arrays(np.uint8, count)),
        ),
        draw(arrays.arrays(np.uint8, draw(st.integers(0, 3)))),
    )


@given(
    st.lists(st.tuples(scenes(), actions, reasons), max_size=6, unique_by=lambda row: row[0].tick)
)
def test_recordings_are_read_back_unchanged(ticks):
    ticks = sorted(ticks, key=lambda row: row[0].tick)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "episode.parquet"
        recorder = Recorder(path, {})
        for tick in ticks:
            recorder.add(*tick)
        recorder.close()
        recording = Recording.load(path)
    assert recording.reasons == [reason for _, _, reason in ticks]
    for (scene, action, _), read, answer in zip(ticks, recording, recording.actions, strict=True):
        assert (read.tick, read.ego) == (scene.tick, scene.ego)
        assert read.lights.tobytes() == scene.lights.tobytes()
        for name in ("ids", "poses", "speeds", "extents", "kinds"):
            one, other = getattr(read.actors, name), getattr(scene.actors, name)
            assert one.shape == other.shape
            assert one.tobytes() == other.tobytes()
        assert same(answer, action)
