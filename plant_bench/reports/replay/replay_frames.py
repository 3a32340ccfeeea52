"""Converts a recording to replay frames: ego, actors and lights at 10 Hz."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8

from plant_bench.data.recording import Recording
from plant_bench.world.scene import TICK, Scene

FRAME_TICKS = 2  # ticks between two frames; the page interpolates
FRAME = FRAME_TICKS * TICK  # s


@dataclass(frozen=True, eq=False)
class Tracks:
    """Tracks of the actors while they are in sight; an actor that reappears has a second track.

    Attributes:
        ids: Id of each track's actor.
        kinds: `ActorKind` of each track's actor.
        extents: Full length and width, metres.
        first: The first frame of each track.
        starts: Index at which each track begins in `poses`, and the total length.
        poses: x, y and unwrapped yaw of all tracks, concatenated, one row per frame.
    """

    ids: Int[np.ndarray, " tracks"]
    kinds: UInt8[np.ndarray, " tracks"]
    extents: Float[np.ndarray, "tracks 2"]
    first: Int[np.ndarray, " tracks"]
    starts: Int[np.ndarray, " bounds"]
    poses: Float[np.ndarray, "rows 3"]


@dataclass(frozen=True, eq=False)
class Frames:
    """An episode, one row every `FRAME` seconds.

    Attributes:
        egos: Columns as `EGO_COLUMNS`; yaw is unwrapped.
        tracks: Tracks of the other actors.
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
    """Return the frames of a complete recording.

    Raises:
        InputError: The recording is thinned.
    """
    scenes = [recording[row] for row in range(0, len(recording), FRAME_TICKS)]
    egos = recording.egos[::FRAME_TICKS].copy()
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
