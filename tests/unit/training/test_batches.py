"""Order, padding and the split by route."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.errors import InputError
from plant_bench.training.batches import epoch_batches, split_by_route
from plant_bench.training.encodings import load_encodings, stack_encodings
from plant_bench.training.frame_store import load_frames
from plant_bench.training.learners import LearnerSpec

LEARNER = LearnerSpec("plant", PlanTOptions())


def test_each_epoch_has_every_sample_once_in_another_order() -> None:
    counts = np.random.default_rng(0).integers(1, 20, 1000)
    one = epoch_batches(counts, 32, seed=3, epoch=0)
    assert sorted(np.concatenate(one).tolist()) == list(range(1000))
    again = epoch_batches(counts, 32, seed=3, epoch=0)
    assert all(map(np.array_equal, one, again))
    other = epoch_batches(counts, 32, seed=3, epoch=1)
    assert not np.array_equal(np.concatenate(one), np.concatenate(other))
    padding = sum(len(batch) * counts[batch].max() for batch in one)
    assert padding < 1.25 * counts.sum()


def test_training_and_validation_share_no_route(data: Path, make_data: Callable[..., Path]) -> None:
    frames = load_frames([data])
    split = split_by_route(frames, 0.1, 0)
    assert len(split.held_out) == 1
    assert {len(split.training), len(split.validation)} == {17, 34}
    everything = split_by_route(frames, 0.0, 0)
    assert (len(everything.training), len(everything.validation)) == (51, 0)
    with pytest.raises(InputError, match="No training samples"):
        split_by_route(load_frames([make_data("alone", "one")]), 0.1, 0)


def test_stationary_samples_can_be_left_out(make_data: Callable[..., Path]) -> None:
    """The ego stands for 6 s, so six frames have stationary futures, and then drives."""
    folder = make_data("data", "one", "two", starts_at=140)
    frames = load_frames([folder])
    stationary = frames.stationary(np.arange(len(frames)))

    split = split_by_route(frames, 0.0, 0, stationary_fraction=0.0)

    assert split.left_out == int(stationary.sum()) == 2 * 6
    np.testing.assert_array_equal(split.training, np.flatnonzero(~stationary))
    some = split_by_route(frames, 0.0, 0, stationary_fraction=0.5)
    assert 0 < some.left_out < split.left_out
    assert set(split.training) < set(some.training)


def test_the_fingerprint_covers_what_samples_are_made_of(
    data: Path, make_data: Callable[..., Path]
) -> None:
    before = load_frames([data]).fingerprint
    assert load_frames([data]).fingerprint == before
    answers: Any = {"answers": lambda _tick: None}
    others = [
        make_data("a", "one", "two", "one", leaves_at=200),
        make_data("b", "two", "one", "one"),
        make_data("c", "one", "two"),
        make_data("d", "one", "two", "one", disturbed=range(200, 210), every=10, **answers),
    ]
    found = {load_frames([folder]).fingerprint for folder in others}
    assert len(found | {before}) == 5
    assert load_frames([data, others[0]]).fingerprint not in found | {before}


def test_batches_are_padded(data: Path) -> None:
    frames = load_frames([data])
    encodings = load_encodings(frames, LEARNER)
    learner = LEARNER.build()
    kinds = encodings.packs[0].columns["kinds"].copy()
    kinds[encodings.starts[0][3] : encodings.starts[0][4] - 1] = 3
    encodings.packs[0].columns["kinds"] = kinds

    batch = encodings.batch(np.array([3, 0]))

    assert batch["kinds"].tolist() == [[3, 3, 2], [1, 2, 2]]
    assert np.isnan(batch["futures"]).tolist() == [[[False] * 6, [True] * 6, [True] * 6]] * 2
    first = learner.encode(frames.frame(0, learner.inputs))
    np.testing.assert_array_equal(batch["waypoints"][1], first["waypoints"])
    assert encodings.batch(np.array([], np.int64))["kinds"].shape == (0, 1)


def test_stored_batches_equal_newly_encoded_ones(make_data: Callable[..., Path]) -> None:
    """Frames of two folders, in which an actor disappears, in any order."""
    folders = [make_data("a", "one", "two", leaves_at=120), make_data("b", "two", "three")]
    frames = load_frames(folders)
    encodings, learner = load_encodings(frames, LEARNER), LEARNER.build()
    chosen = np.random.default_rng(1).permutation(len(frames))[:40]

    batch = encodings.batch(chosen)

    encoded = [learner.encode(frames.frame(at, learner.inputs)) for at in chosen.tolist()]
    anew = stack_encodings(encoded, dict(learner.padding))
    assert set(batch) == set(anew)
    for name, values in anew.items():
        np.testing.assert_array_equal(batch[name], values)
        assert batch[name].dtype == values.dtype
    assert set(np.unique(encodings.counts[chosen])) == {2, 3}
