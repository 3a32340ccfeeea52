"""Recordings as frames and PlanT's samples of them, and their cache."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.agent import Control, Input, Plan
from plant_bench.agents.careful.driver import RESTING_INTERVAL
from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.data.recording import Recording
from plant_bench.data.tick_log import Action
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenKind, TokenSpec
from plant_bench.training import frame_store
from plant_bench.training.encodings import Encodings, encodings_key, load_encodings
from plant_bench.training.frame_store import Frames, load_frames
from plant_bench.training.frames import MAX_ACTION_AGE, TargetKind, rows_of
from plant_bench.training.learners import LearnerSpec
from plant_bench.world.route import Route

SPEED = 8.0  # m/s, of the ego and its leader

LEARNER = LearnerSpec("plant", PlanTOptions())


class Samples:
    """PlanT's encodings of one folder, as arrays."""

    def __init__(self, encodings: Encodings) -> None:
        (pack,) = encodings.packs
        self.starts, self.columns = encodings.starts[0], pack.columns

    def __len__(self) -> int:
        return len(self.starts) - 1

    def __getattr__(self, name: str) -> np.ndarray:
        return self.columns[name]


Make = Callable[..., Samples]


def frames_of(data: Path, **facts: Any) -> Frames:
    return load_frames([data], **facts)


@pytest.fixture
def made(make_data: Callable[..., Path]) -> Make:
    count = 0

    def make(targets: TargetKind = "future", **facts: Any) -> Samples:
        nonlocal count
        count += 1
        folder = make_data(f"data-{count}", "one", **facts)
        return Samples(load_encodings(frames_of(folder, targets=targets), LEARNER))

    return make


def test_waypoints_are_future_ego_positions(made: Make) -> None:
    samples = made()
    ahead = 0.5 * SPEED * np.arange(1, 5)
    expected = np.stack((ahead, np.zeros(4)), axis=1)
    for waypoints in samples.waypoints:
        assert waypoints == pytest.approx(expected, abs=1e-4)
    assert samples.target == pytest.approx(np.array([[20.0, 0.0]] * len(samples)), abs=1.1)
    assert samples.speed == pytest.approx(SPEED)
    assert samples.limit == pytest.approx(13.0)
    assert not samples.red.any()


def test_start_and_end_of_an_episode_are_left_out(made: Make) -> None:
    assert len(made(ticks=260)) == 17  # samples 5 to 21: tick 219 + 40 is the last
    assert len(made(ticks=91)) == 1
    assert len(made(ticks=90)) == 0
    assert len(made(ticks=1)) == 0


def test_maximum_response_age_equals_the_resting_interval() -> None:
    assert MAX_ACTION_AGE == RESTING_INTERVAL


def test_frame_holds_past_and_future_actors(make_data: Callable[..., Path]) -> None:
    """The leader disappears half a second after the fifth frame."""
    folder = make_data("data", "one", leaves_at=100, every=10, disturbed=range(120, 131))
    frames = frames_of(folder, targets="future")
    inputs = frozenset({Input.OBJECTS, Input.LIGHT})

    seen = [frames.frame(number, inputs) for number in range(5)]

    assert [frame.observation.time for frame in seen] == pytest.approx([2.5, 3.0, 3.5, 4.0, 7.0])
    last = seen[3]
    assert last.observation.actors is not None
    assert [len(some) for some in (last.before, last.observation.actors, last.later)] == [1, 1, 1]
    ahead = [float(frame.before.poses[0, 0]) for frame in seen[:4]]
    step = 0.5 * SPEED * np.cos(0.5)
    assert np.diff(ahead) == pytest.approx(step, abs=1e-4)
    assert float(last.later.poses[0, 0]) - ahead[-1] == pytest.approx(2 * step, abs=1e-4)
    assert len(seen[4].before) == 0
    assert last.observation.route is None
    assert last.observation.privileged is None
    assert last.route.id == "one"
    assert last.answer is None
    assert not last.disturbed


def test_futures_of_actors_are_in_the_current_ego_frame(made: Make) -> None:
    samples = made(leaves_at=100)
    first = slice(samples.starts[0], samples.starts[1])
    assert samples.kinds[first].tolist() == [TokenKind.VEHICLE, TokenKind.ROUTE, TokenKind.ROUTE]
    now, later = samples.attributes[first][0], samples.futures[first][0]
    assert now == pytest.approx([SPEED, 12.0, 0.0, 0.0, 1.8, 4.5], abs=1e-4)
    assert later == pytest.approx([SPEED, 12.0 + 0.5 * SPEED, 0.0, 0.0, 1.8, 4.5], abs=1e-4)
    assert np.isnan(samples.futures[first][1:]).all()
    last_seen = samples.starts[4]  # tick 90: gone at tick 100
    assert samples.kinds[last_seen] == TokenKind.VEHICLE
    assert np.isnan(samples.futures[last_seen]).all()


def test_a_thinned_recording_gives_the_same_samples(made: Make) -> None:
    whole, thinned = made(leaves_at=100), made(leaves_at=100, every=10)
    assert set(thinned.columns) == set(whole.columns)
    for name in whole.columns:
        np.testing.assert_array_equal(thinned.columns[name], whole.columns[name])


def test_samples_have_no_perturbation_in_their_future(made: Make) -> None:
    left = made(every=10, disturbed=range(120, 131))  # of 50, 60, ... 210: 90 to 130 are gone
    assert len(left) == len(made()) - 5


def always(acceleration: float) -> Callable[[int], Action]:
    """Answers at every second tick, as the expert does."""
    return lambda tick: None if tick % 2 else Control(acceleration, 0.1)


@pytest.mark.parametrize(
    ("acceleration", "ahead"),
    [
        (0.0, [4.0, 8.0, 12.0, 16.0]),
        (1.0, [4.125, 8.5, 13.125, 18.0]),
        (-8.0, [3.0, 4.0, 4.0, 4.0]),  # it stands after a second, and does not go back
        (10.0, [5.25, 11.75, 18.25, 24.75]),  # 13 m/s, the speed limit, after half a second
    ],
)
def test_expert_action_waypoints_follow_its_acceleration(
    made: Make, acceleration: float, ahead: list[float]
) -> None:
    samples = made("expert-action", answers=always(acceleration))
    expected = np.stack((ahead, np.zeros(4)), axis=1)
    assert len(samples) == 17
    for waypoints in samples.waypoints:
        assert waypoints == pytest.approx(expected, abs=3e-3)
    assert samples.target == pytest.approx(np.array([[20.0, 0.0]] * len(samples)), abs=1.1)


def test_last_expert_action_is_held_between_decisions(made: Make) -> None:
    told = {48: Control(1.0, 0.0), 49: None, 44: Control(-1.0, 0.0)}

    def answers(tick: int) -> Action:
        return told.get(tick, None if tick in (50, 51) else Control(0.0, 0.0))

    first = made("expert-action", answers=answers).waypoints[0]  # of tick 50
    assert first[:, 0] == pytest.approx([4.125, 8.5, 13.125, 18.0], abs=3e-3)


def test_expert_action_targets_include_perturbed_frames(made: Make) -> None:
    facts: Any = {"every": 10, "disturbed": range(60, 200), "answers": always(1.0)}
    assert len(made("expert-action", **facts)) == 17
    assert len(made("future", **facts)) < 17


@pytest.mark.parametrize(
    "answer",
    [None, Plan(np.zeros((4, 2))), lambda tick: Control(0.0, 0.0) if tick < 46 else None],
)
def test_missing_expert_action_gives_one_message(made: Make, answer: Any) -> None:
    answers = answer if callable(answer) else lambda _tick: answer
    with pytest.raises(
        InputError, match="Row 50 of the recording has no acceleration of an expert"
    ):
        made("expert-action", answers=answers)


def test_a_recording_of_another_route_is_refused(
    tmp_path: Path, route: Route, write: Callable[..., Path]
) -> None:
    path = write(tmp_path / "episode.parquet", route)
    other = replace(route, speed_limits=np.full(201, 9.0))
    with pytest.raises(InputError, match="does not match route one"):
        rows_of(Recording.load(path), other)


def test_a_recording_of_another_world_is_refused(
    tmp_path: Path, route: Route, write: Callable[..., Path]
) -> None:
    path = write(tmp_path / "episode.parquet", route, protocol="longest6-sumo-v0")
    with pytest.raises(InputError, match="Expected a recording of protocol"):
        rows_of(Recording.load(path), route)


def test_frames_and_samples_are_cached(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[int, int]] = []
    first = frames_of(data, on_progress=lambda *done: told.append(done))
    samples = load_encodings(first, LEARNER, on_progress=lambda *done: told.append(done))
    assert told == [(1, 3), (2, 3), (3, 3)] * 2
    assert list(first.routes.values()) == ["one", "two", "one"]
    monkeypatch.setattr(frame_store, "rows_of", None)
    monkeypatch.setattr("plant_bench.agents.plant.learner.encode", None)
    again = load_encodings(frames_of(data), LEARNER)
    chosen = np.arange(20, 30)
    np.testing.assert_array_equal(
        again.batch(chosen)["waypoints"], samples.batch(chosen)["waypoints"]
    )


def test_sample_key_covers_what_samples_depend_on() -> None:
    key = encodings_key(LEARNER, "future")
    farther = PlanTOptions(PlanTConfig(tokens=TokenSpec(reach=50.0)))
    assert encodings_key(LearnerSpec("plant", farther), "future") != key
    assert encodings_key(LEARNER, "expert-action") != key
    assert (
        encodings_key(LearnerSpec("plant", replace(PlanTOptions(), overshoot_weight=2.0)), "future")
        == key
    )


def test_unusable_data_folders_raise_input_error(data: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="There is no data in"):
        frames_of(tmp_path / "empty")
    broken = next((data / "episodes").glob("c.parquet"))
    broken.write_bytes(b"nothing")
    with pytest.raises(InputError, match="Not a recording"):
        frames_of(data)
    part = next((data / "frames").rglob("a-*.npz"))
    whole = part.read_bytes()
    broken.unlink()
    part.write_bytes(whole[:100])
    with pytest.raises(InputError, match="Broken part"):
        frames_of(data)
    part.write_bytes(whole)
    frames_of(data)
    column = next((data / "frames").rglob("ego.npy"))
    column.write_bytes(column.read_bytes()[:300])
    with pytest.raises(InputError, match="Broken pack"):
        frames_of(data)
    (data / "routes" / "suite.json").unlink()
    with pytest.raises(InputError, match=r"No routes"):
        frames_of(data)
