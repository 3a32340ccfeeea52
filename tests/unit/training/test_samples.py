"""Recordings as samples, and their cache."""

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.agent import Control, Plan
from plant_bench.data.ticks import Action
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenKind, TokenSpec
from plant_bench.training import shards
from plant_bench.training.samples import Samples, TargetKind, joined, samples_of
from plant_bench.training.shards import load_shards
from plant_bench.world.route import Route

SPEED = 8.0  # m/s, of the ego and its leader

Make = Callable[..., Samples]


@pytest.fixture
def made(tmp_path: Path, route: Route, write: Callable[..., Path]) -> Make:
    def make(targets: TargetKind = "future", **facts: Any) -> Samples:
        path = write(tmp_path / "episode.parquet", route, **facts)
        return samples_of(Recording.load(path), route, TokenSpec(), targets)

    return make


def test_waypoints_lie_where_the_ego_will_be(made: Make) -> None:
    samples = made()
    ahead = 0.5 * SPEED * np.arange(1, 5)
    expected = np.stack((ahead, np.zeros(4)), axis=1)
    for waypoints in samples.waypoints:
        assert waypoints == pytest.approx(expected, abs=1e-4)
    assert samples.target == pytest.approx(np.array([[20.0, 0.0]] * len(samples)), abs=1.1)
    assert samples.speed == pytest.approx(SPEED)
    assert samples.limit == pytest.approx(13.0)
    assert not samples.red.any()


def test_ends_of_the_episode_are_left_out(made: Make) -> None:
    assert len(made(ticks=260)) == 17  # samples 5 to 21: tick 219 + 40 is the last
    assert len(made(ticks=91)) == 1
    assert len(made(ticks=90)) == 0
    assert len(made(ticks=1)) == 0


def test_the_future_of_others_is_told_in_the_frame_of_now(made: Make) -> None:
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
    for field in fields(Samples):
        np.testing.assert_array_equal(getattr(thinned, field.name), getattr(whole, field.name))


def test_no_sample_has_a_disturbance_in_its_future(made: Make) -> None:
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
def test_an_answers_waypoints_lie_where_its_acceleration_leads(
    made: Make, acceleration: float, ahead: list[float]
) -> None:
    samples = made("answer", answers=always(acceleration))
    expected = np.stack((ahead, np.zeros(4)), axis=1)
    assert len(samples) == 17
    for waypoints in samples.waypoints:
        assert waypoints == pytest.approx(expected, abs=3e-3)
    assert samples.target == pytest.approx(np.array([[20.0, 0.0]] * len(samples)), abs=1.1)


def test_the_last_answer_counts_while_the_expert_rests(made: Make) -> None:
    told = {48: Control(1.0, 0.0), 49: None, 44: Control(-1.0, 0.0)}

    def answers(tick: int) -> Action:
        return told.get(tick, None if tick in (50, 51) else Control(0.0, 0.0))

    first = made("answer", answers=answers).waypoints[0]  # of tick 50
    assert first[:, 0] == pytest.approx([4.125, 8.5, 13.125, 18.0], abs=3e-3)


def test_answers_are_learned_where_something_else_was_executed(made: Make) -> None:
    facts: Any = {"every": 10, "disturbed": range(60, 200), "answers": always(1.0)}
    assert len(made("answer", **facts)) == 17
    assert len(made("future", **facts)) < 17


@pytest.mark.parametrize(
    "answer", [None, Plan(np.zeros((4, 2))), lambda tick: Control(0.0, 0.0) if tick < 46 else None]
)
def test_a_missing_answer_is_one_clear_error(made: Make, answer: Any) -> None:
    answers = answer if callable(answer) else lambda _tick: answer
    with pytest.raises(InputError, match="Row 50 of a recording holds no acceleration"):
        made("answer", answers=answers)


def test_parts_and_joints(made: Make) -> None:
    samples = made(leaves_at=100)
    again = joined([samples.only(slice(0, 3)), samples.only(slice(3, len(samples)))])
    for field in fields(Samples):
        np.testing.assert_array_equal(getattr(again, field.name), getattr(samples, field.name))


def test_a_recording_of_another_route_is_refused(
    tmp_path: Path, route: Route, write: Callable[..., Path]
) -> None:
    path = write(tmp_path / "episode.parquet", route)
    other = replace(route, speed_limits=np.full(201, 9.0))
    with pytest.raises(InputError, match="does not fit route one"):
        samples_of(Recording.load(path), other, TokenSpec())


def test_a_recording_of_another_world_is_refused(
    tmp_path: Path, route: Route, write: Callable[..., Path]
) -> None:
    path = write(tmp_path / "episode.parquet", route, protocol="longest6-sumo-v0")
    with pytest.raises(InputError, match="of another world than"):
        samples_of(Recording.load(path), route, TokenSpec())


def test_samples_are_made_once(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[int, int]] = []
    first = load_shards(data, TokenSpec(), on_progress=lambda *done: told.append(done))
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert [shard.route for shard in first] == ["one", "two", "one"]
    monkeypatch.setattr(shards, "samples_of", None)
    again = load_shards(data, TokenSpec())
    np.testing.assert_array_equal(again[1].samples.waypoints, first[1].samples.waypoints)
    assert shards.shards_key(TokenSpec()) != shards.shards_key(TokenSpec(reach=50.0))
    assert shards.shards_key(TokenSpec()) != shards.shards_key(TokenSpec(), "answer")


def test_bad_folders_are_input_errors(data: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No recordings found"):
        load_shards(tmp_path / "empty", TokenSpec())
    broken = next((data / "episodes").glob("c.parquet"))
    broken.write_bytes(b"nothing")
    with pytest.raises(InputError, match="Not a recording"):
        load_shards(data, TokenSpec())
    broken.unlink()
    load_shards(data, TokenSpec())
    shard = next((data / "samples").rglob("a-*.npz"))
    shard.write_bytes(shard.read_bytes()[:100])
    with pytest.raises(InputError, match="Broken samples"):
        load_shards(data, TokenSpec())
    (data / "routes" / "suite.json").unlink()
    with pytest.raises(InputError, match=r"No routes"):
        load_shards(data, TokenSpec())
