"""A recording as frames: the ego, whoever else was in sight, and the lights, ten times a second."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8

from plant_bench.data.recording import Recording
from plant_bench.world.scene import TICK, Scene

EVERY = 2  # ticks between two frames; the page draws what is between by itself
FRAME = EVERY * TICK  # s


@dataclass(frozen=True, eq=False)
class Tracks:
    """Where each actor was as long as it was in sight; who came back has two tracks.

    Attributes:
        ids: Of the actors.
        kinds: `ActorKind` values.
        extents: Full length and width, metres.
        first: The frame in which each track begins.
        starts: Where each track begins in `poses`; one more than there are tracks.
        poses: x, y and unwrapped yaw of all tracks, one after the other, a row a frame.
    """

    ids: Int[np.ndarray, " tracks"]
    kinds: UInt8[np.ndarray, " tracks"]
    extents: Float[np.ndarray, "tracks 2"]
    first: Int[np.ndarray, " tracks"]
    starts: Int[np.ndarray, " bounds"]
    poses: Float[np.ndarray, "rows 3"]


@dataclass(frozen=True, eq=False)
class Frames:
    """An episode, a row every `FRAME` seconds.

    Attributes:
        egos: Columns as `EGO_COLUMNS`; yaw is unwrapped.
        tracks: The others.
        lights: `Light` values of the route's signals.
    """

    egos: Float[np.ndarray, "frames 6"]
    tracks: Tracks
    lights: UInt8[np.ndarray, "frames signals"]

    def __len__(self) -> int:
        return len(self.egos)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (len(self) - 1) * FRAME


def frames_of(recording: Recording) -> Frames:
    """Return the frames of a recording that is whole.

    Raises:
        InputError: It is thinned.
    """
    scenes = [recording[row] for row in range(0, len(recording), EVERY)]
    egos = recording.egos[::EVERY].copy()
    egos[:, 2] = np.unwrap(egos[:, 2])
    return Frames(egos, _tracks(scenes), np.stack([scene.lights for scene in scenes]))


def _tracks(scenes: Sequence[Scene]) -> Tracks:
    actors = [scene.actors for scene in scenes]
    ids = np.concatenate([item.ids for item in actors])
    frames = np.repeat(np.arange(len(actors)), [len(item) for item in actors])
    order = np.lexsort((frames, ids))
    ids, frames = ids[order], frames[order]
    poses = np.concatenate([item.poses for item in actors])[order].astype(float)
    extents = np.concatenate([item.extents for item in actors])[order].astype(float)
    kinds = np.concatenate([item.kinds for item in actors])[order]
    begins = (np.diff(ids, prepend=-1) != 0) | (np.diff(frames, prepend=-1) != 1)
    firsts = np.flatnonzero(begins)
    starts = np.append(firsts, len(ids))
    for low, high in itertools.pairwise(starts):
        poses[low:high, 2] = np.unwrap(poses[low:high, 2])
    return Tracks(ids[firsts], kinds[firsts], extents[firsts], frames[firsts], starts, poses)
