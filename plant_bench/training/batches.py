"""Splits frames by route into a training and a validation set, and forms reproducible batches."""

import hashlib
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from plant_bench.errors import InputError
from plant_bench.training.frame_store import Frames

SORTING_WINDOW = 16  # batches within which samples are sorted by number of objects


@dataclass(frozen=True, eq=False)
class Split:
    """Training frames, and validation frames of other routes.

    Attributes:
        frames: All frames.
        training: Indices of the training frames.
        validation: Indices of the validation frames (held-out routes); may be empty.
        held_out: Ids of the held-out routes.
        left_out: Number of frames of the training routes that are dropped.
    """

    frames: Frames
    training: Int[np.ndarray, " training"]
    validation: Int[np.ndarray, " validation"]
    held_out: tuple[str, ...]
    left_out: int = 0

    @property
    def episodes(self) -> int:
        """Number of episodes, training and validation."""
        return len(self.frames.routes)

    @property
    def fingerprint(self) -> str:
        """Hash of the data, see `Frames.fingerprint`."""
        return self.frames.fingerprint


def split_by_route(
    frames: Frames, share: float, seed: int, stationary_fraction: float = 1.0
) -> Split:
    """Hold out a share of the routes for validation, chosen by a hash of their ids and the seed.

    Args:
        frames: The frames to split.
        share: Share of the routes to hold out; at least one route unless it is 0.
        seed: Seed of the choice.
        stationary_fraction: Share to keep of the training frames in which the ego is and stays
            stationary.

    Raises:
        InputError: No training frames are left.
    """
    names = sorted(set(frames.routes.values()))
    ranked = sorted(names, key=lambda name: hashlib.sha256(f"{seed}|{name}".encode()).digest())
    count = 0 if share == 0.0 else max(round(share * len(names)), 1)
    held_out = frozenset(ranked[:count])
    checked = frames.route_mask(held_out)
    known = np.flatnonzero(~checked)
    if not len(known):
        message = (
            f"No training samples: {len(frames.routes)} episodes on {len(names)} routes, of which "
            f"{count} are held out. Expected episodes of at least 5 s on at least two routes."
        )
        raise InputError(message)
    training = _drop_stationary(frames, known, stationary_fraction, seed)
    return Split(
        frames,
        training,
        np.flatnonzero(checked),
        tuple(sorted(held_out)),
        len(known) - len(training),
    )


def _drop_stationary(frames: Frames, known: np.ndarray, share: float, seed: int) -> np.ndarray:
    """Keep only a share of the many, similar frames in which the ego is and stays stationary."""
    if share == 1.0:
        return known
    kept = np.random.default_rng((seed, len(known))).random(len(known)) < share
    return known[kept | ~frames.stationary(known)]


def epoch_batches(
    counts: Int[np.ndarray, " samples"], batch: int, *, seed: int, epoch: int
) -> list[np.ndarray]:
    """Return the sample indices of each batch of an epoch; equal arguments give equal batches.

    Samples are shuffled, then sorted by number of objects within `SORTING_WINDOW` batches, which
    halves the padding; then the batches are shuffled. Each sample occurs once; one batch may be
    smaller than the others.
    """
    rng = np.random.default_rng((seed, epoch))
    order = rng.permutation(len(counts))
    chunk = SORTING_WINDOW * batch
    parts = [order[start : start + chunk] for start in range(0, len(order), chunk)]
    parts = [part[counts[part].argsort(kind="stable")] for part in parts]
    batches = [part[at : at + batch] for part in parts for at in range(0, len(part), batch)]
    return [batches[place] for place in rng.permutation(len(batches))]
