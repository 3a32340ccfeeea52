"""Splits frames by route into training and validation; forms reproducible batches."""

import hashlib
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from plant_bench.errors import InputError
from plant_bench.training.frame_store import Frames

SORTED_TOGETHER = 16  # batches within which frames of like numbers of objects are put together


@dataclass(frozen=True, eq=False)
class Split:
    """Training frames, and validation frames of other routes.

    Attributes:
        frames: All frames.
        training: Indices of the training frames.
        validation: Indices of the frames of the held-out routes; may be empty.
        held_out: Ids of the held-out routes.
        left_out: Number of frames of the training routes that are not used.
    """

    frames: Frames
    training: Int[np.ndarray, " training"]
    validation: Int[np.ndarray, " validation"]
    held_out: tuple[str, ...]
    left_out: int = 0

    @property
    def episodes(self) -> int:
        """Number of episodes in all."""
        return len(self.frames.routes)

    @property
    def fingerprint(self) -> str:
        """A hash of what all frames are made of."""
        return self.frames.fingerprint


def split_by_route(
    frames: Frames, share: float, seed: int, stationary_fraction: float = 1.0
) -> Split:
    """Hold a share of the routes out, chosen by a hash of their ids and the seed.

    Args:
        frames: To be split.
        share: Of the routes to be held out.
        seed: Of the choice.
        stationary_fraction: Share kept of the frames in which the ego is and stays stationary.

    Raises:
        InputError: There are no frames, or too few routes to hold one out.
    """
    names = sorted(set(frames.routes.values()))
    ranked = sorted(names, key=lambda name: hashlib.sha256(f"{seed}|{name}".encode()).digest())
    count = 0 if share == 0.0 else max(round(share * len(names)), 1)
    held_out = frozenset(ranked[:count])
    checked = frames.route_mask(held_out)
    known = np.flatnonzero(~checked)
    if not len(known):
        message = (
            f"No samples to learn from: {len(frames.routes)} episodes on {len(names)} routes, "
            f"{count} of them held out. Episodes of 5 s and more on two routes and more are needed."
        )
        raise InputError(message)
    training = _without_rest(frames, known, stationary_fraction, seed)
    return Split(
        frames,
        training,
        np.flatnonzero(checked),
        tuple(sorted(held_out)),
        len(known) - len(training),
    )


def _without_rest(frames: Frames, known: np.ndarray, share: float, seed: int) -> np.ndarray:
    """Drop a part of the frames in which the ego is stationary: they are many and similar."""
    if share == 1.0:
        return known
    lucky = np.random.default_rng((seed, len(known))).random(len(known)) < share
    return known[lucky | ~frames.stationary(known)]


def epoch_batches(
    counts: Int[np.ndarray, " samples"], batch: int, *, seed: int, epoch: int
) -> list[np.ndarray]:
    """Return the samples of each batch of an epoch; equal arguments give equal batches.

    Samples are shuffled, then within `SORTED_TOGETHER` batches put in order of their counts of
    objects, which halves the padding; then the batches are shuffled. Each sample occurs once; the
    last ones that do not fill a batch make a smaller one.
    """
    rng = np.random.default_rng((seed, epoch))
    order = rng.permutation(len(counts))
    chunk = SORTED_TOGETHER * batch
    parts = [order[start : start + chunk] for start in range(0, len(order), chunk)]
    parts = [part[counts[part].argsort(kind="stable")] for part in parts]
    batches = [part[at : at + batch] for part in parts for at in range(0, len(part), batch)]
    return [batches[place] for place in rng.permutation(len(batches))]
