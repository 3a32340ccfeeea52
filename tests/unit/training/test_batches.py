"""Order, padding and the split by route."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import torch

from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenKind, TokenSpec
from plant_bench.training.batches import collate, epoch_batches, split_by_route
from plant_bench.training.samples import Samples
from plant_bench.training.shards import load_shards


def test_each_sample_once_an_epoch_in_another_order() -> None:
    counts = np.random.default_rng(0).integers(1, 20, 1000)
    one = epoch_batches(counts, 32, seed=3, epoch=0)
    assert sorted(np.concatenate(one).tolist()) == list(range(1000))
    again = epoch_batches(counts, 32, seed=3, epoch=0)
    assert all(map(np.array_equal, one, again))
    other = epoch_batches(counts, 32, seed=3, epoch=1)
    assert not np.array_equal(np.concatenate(one), np.concatenate(other))
    padding = sum(len(batch) * counts[batch].max() for batch in one)
    assert padding < 1.25 * counts.sum()


def test_routes_are_not_shared(data: Path) -> None:
    shards = load_shards(data, TokenSpec())
    split = split_by_route(shards, 0.1, 0)
    assert len(split.held_out) == 1
    assert {len(split.training), len(split.validation)} == {17, 34}
    everything = split_by_route(shards, 0.0, 0)
    assert (len(everything.training), len(everything.validation)) == (51, 0)
    with pytest.raises(InputError, match="No samples to learn from"):
        split_by_route([shard for shard in shards if shard.route == "one"], 0.1, 0)


def test_samples_of_standing_still_can_be_left_out(data: Path) -> None:
    shards = load_shards(data, TokenSpec())
    for shard in shards:
        shard.samples.speed[:2] = 0.0
        shard.samples.waypoints[:2] = 0.0
    whole = split_by_route(shards, 0.0, 0).training
    resting = whole.resting

    split = split_by_route(shards, 0.0, 0, resting=0.0)

    assert split.left_out == int(resting.sum()) >= 2 * len(shards)
    kept = np.flatnonzero(~resting)
    np.testing.assert_array_equal(split.training.waypoints, whole.waypoints[kept])
    last = slice(int(whole.starts[kept[-1]]), int(whole.starts[kept[-1] + 1]))
    own = slice(int(split.training.starts[-2]), None)
    np.testing.assert_array_equal(split.training.attributes[own], whole.attributes[last])


@pytest.mark.parametrize("name", [item.name for item in fields(Samples)])
def test_the_fingerprint_covers_every_array_of_a_sample(data: Path, name: str) -> None:
    shards = load_shards(data, TokenSpec())
    before = split_by_route(shards, 0.1, 0).fingerprint
    assert split_by_route(load_shards(data, TokenSpec()), 0.1, 0).fingerprint == before
    values = getattr(shards[-1].samples, name)
    values[0] = values[0] + 1
    assert split_by_route(shards, 0.1, 0).fingerprint != before


def test_padding(data: Path) -> None:
    split = split_by_route(load_shards(data, TokenSpec()), 0.0, 0)
    samples = split.training
    samples.kinds[samples.starts[3] : samples.starts[4]] = TokenKind.VULNERABLE
    batch, targets = collate(samples, np.array([3, 0]))
    assert batch.kinds.tolist() == [[3, 3, 3], [1, 2, 2]]
    assert targets.futures.isnan().tolist() == [[[False] * 6, [True] * 6, [True] * 6]] * 2
    torch.testing.assert_close(targets.waypoints[1], torch.from_numpy(samples.waypoints[0]))
    nothing, _ = collate(samples, np.array([], np.int64))
    assert nothing.kinds.shape == (0, 1)
