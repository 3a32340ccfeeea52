"""Samples as batches: split by route, put in a reproducible order, padded."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from plant_bench.agents.plant.network import Batch
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenKind
from plant_bench.training.samples import Samples, joined
from plant_bench.training.shards import Shard

SORTED_TOGETHER = 16  # batches within which samples of like token counts are put together


@dataclass(frozen=True, eq=False, slots=True)
class Targets:
    """What a batch should be answered with.

    Attributes:
        waypoints: In the ego frame, metres.
        futures: The tokens' attributes half a second later; NaN where there is nothing to learn.
    """

    waypoints: Float[Tensor, "batch waypoints 2"]
    futures: Float[Tensor, "batch tokens 6"]


@dataclass(frozen=True, eq=False)
class Split:
    """The samples to learn from, and those of other routes to check with.

    Attributes:
        training: To learn from.
        validation: Of the routes held out; may be empty.
        held_out: Ids of these routes.
        episodes: Number of episodes in all.
        fingerprint: A hash of all samples.
        left_out: Number of samples of the same routes as `training` that are not learned from.
    """

    training: Samples
    validation: Samples
    held_out: tuple[str, ...]
    episodes: int
    fingerprint: str
    left_out: int = 0


def split_by_route(shards: Sequence[Shard], share: float, seed: int, resting: float = 1.0) -> Split:
    """Hold a share of the routes out, chosen by a hash of their ids and the seed.

    Args:
        shards: The samples.
        share: Of the routes to be held out.
        seed: Of the choice.
        resting: Share that is learnt from of the samples in which the ego stands and stays.

    Raises:
        InputError: There are no samples, or too few routes to hold one out.
    """
    names = sorted({shard.route for shard in shards})
    ranked = sorted(names, key=lambda name: hashlib.sha256(f"{seed}|{name}".encode()).digest())
    count = 0 if share == 0.0 else max(round(share * len(names)), 1)
    held_out = frozenset(ranked[:count])
    learnt = [shard.samples for shard in shards if shard.route not in held_out]
    checked = [shard.samples for shard in shards if shard.route in held_out]
    if sum(map(len, learnt)) == 0:
        message = (
            f"No samples to learn from: {len(shards)} episodes on {len(names)} routes, {count} of "
            "them held out. Episodes of 5 s and more on two routes and more are wanted."
        )
        raise InputError(message)
    nothing = learnt[0].only(slice(0, 0))
    known = joined(learnt)
    training = _without_rest(known, resting, seed)
    return Split(
        training,
        joined(checked) if checked else nothing,
        tuple(sorted(held_out)),
        len(shards),
        _fingerprint(shards),
        len(known) - len(training),
    )


def _without_rest(samples: Samples, share: float, seed: int) -> Samples:
    """Leave some of the samples out in which the ego rests: they are many, and all alike."""
    if share == 1.0:
        return samples
    lucky = np.random.default_rng((seed, len(samples))).random(len(samples)) < share
    return samples.picked(np.flatnonzero(lucky | ~samples.resting))


def epoch_batches(
    counts: Int[np.ndarray, " samples"], batch: int, *, seed: int, epoch: int
) -> list[np.ndarray]:
    """Return the samples of each batch of an epoch; equal arguments give equal batches.

    Samples are shuffled, then within `SORTED_TOGETHER` batches put in order of their token counts,
    which halves the padding; then the batches are shuffled. Each sample occurs once; the last ones
    that do not fill a batch make a smaller one.
    """
    rng = np.random.default_rng((seed, epoch))
    order = rng.permutation(len(counts))
    chunk = SORTED_TOGETHER * batch
    parts = [order[start : start + chunk] for start in range(0, len(order), chunk)]
    parts = [part[counts[part].argsort(kind="stable")] for part in parts]
    batches = [part[at : at + batch] for part in parts for at in range(0, len(part), batch)]
    return [batches[place] for place in rng.permutation(len(batches))]


def collate(samples: Samples, chosen: Int[np.ndarray, " batch"]) -> tuple[Batch, Targets]:
    """Return some samples as a padded batch, and what it should be answered with."""
    counts = samples.counts[chosen]
    most = max(int(counts.max(initial=0)), 1)
    steps = np.arange(most)
    there = steps < counts[:, None]
    at = np.where(there, samples.starts[:-1][chosen][:, None] + steps, 0)
    attributes = np.where(there[..., None], samples.attributes[at], np.float32(0.0))
    kinds = np.where(there, samples.kinds[at], np.uint8(TokenKind.PADDING))
    futures = np.where(there[..., None], samples.futures[at], np.float32(np.nan))
    batch = Batch(
        torch.from_numpy(attributes),
        torch.from_numpy(kinds),
        torch.from_numpy(samples.red[chosen]),
        torch.from_numpy(samples.target[chosen]),
        torch.from_numpy(samples.speed[chosen]),
        torch.from_numpy(samples.limit[chosen]),
    )
    return batch, Targets(torch.from_numpy(samples.waypoints[chosen]), torch.from_numpy(futures))


def _fingerprint(shards: Sequence[Shard]) -> str:
    digest = hashlib.sha256()
    for shard in shards:
        digest.update(shard.route.encode())
        for item in fields(Samples):
            values: np.ndarray = getattr(shard.samples, item.name)
            digest.update(f"{item.name}{values.shape}".encode())
            digest.update(values.tobytes())
    return digest.hexdigest()[:16]
