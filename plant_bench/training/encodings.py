"""Caches the encodings of frames on disk: DIR/encoded/<key>/, see `column_store`."""

import hashlib
import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Int

from plant_bench.errors import InputError
from plant_bench.learner import Encoded, Learner
from plant_bench.training.code_keys import closure_hash
from plant_bench.training.column_store import (
    ColumnStore,
    EpisodeBuilder,
    ProgressCallback,
    open_pack,
    open_packs,
    start_offsets,
)
from plant_bench.training.frame_store import KEY_LENGTH, Episodes, Frames, frames_key
from plant_bench.training.frames import TargetKind
from plant_bench.training.learners import LearnerSpec

ENCODED_FORMAT = 1
COUNT = "count"  # column with each frame's number of objects, in addition to the learner's columns


@dataclass(frozen=True, eq=False)
class Encodings:
    """The encodings of some frames, memory-mapped.

    Attributes:
        padding: As `Learner.padding`.
        packs: The packs that hold the encodings.
        pack: Index in `packs` of each frame's pack.
        row: Row of each frame in its pack.
        starts: For each pack, the first object row of each of its frames, and the end.
    """

    padding: dict[str, float]
    packs: tuple[ColumnStore, ...]
    pack: Int[np.ndarray, " frames"]
    row: Int[np.ndarray, " frames"]
    starts: tuple[np.ndarray, ...]

    @property
    def counts(self) -> Int[np.ndarray, " frames"]:
        """The number of objects of each frame."""
        counts = np.zeros(len(self.row), np.int64)
        for number, starts in enumerate(self.starts):
            in_pack = self.pack == number
            counts[in_pack] = np.diff(starts)[self.row[in_pack]]
        return counts

    def batch(self, chosen: Int[np.ndarray, " batch"]) -> Encoded:
        """Return the encodings of the chosen frames in that order; objects are padded."""
        parts = [
            (place, self.row[chosen[place]], number)
            for number in range(len(self.packs))
            if len(place := np.flatnonzero(self.pack[chosen] == number))
        ]
        counts = np.zeros(len(chosen), np.int64)
        for place, rows, number in parts:
            counts[place] = np.diff(self.starts[number])[rows]
        most = max(int(counts.max(initial=0)), 1)
        return {
            name: self._column(name, parts, (len(chosen), most))
            for name in self.packs[parts[0][2] if parts else 0].columns
            if name != COUNT
        }

    def _column(
        self, name: str, parts: Sequence[tuple[np.ndarray, np.ndarray, int]], shape: tuple[int, int]
    ) -> np.ndarray:
        like = self.packs[parts[0][2] if parts else 0].columns[name]
        if name not in self.padding:
            found = np.empty((shape[0], *like.shape[1:]), like.dtype)
            for place, rows, number in parts:
                found[place] = self.packs[number].columns[name][rows]
            return found
        found = np.full((*shape, *like.shape[1:]), self.padding[name], like.dtype)
        for place, rows, number in parts:
            starts = self.starts[number]
            counts = starts[rows + 1] - starts[rows]
            within = _indices_within(counts)
            at = np.repeat(starts[rows], counts) + within
            found[np.repeat(place, counts), within] = self.packs[number].columns[name][at]
        return found


def stack_encodings(encoded: Sequence[Encoded], padding: dict[str, float]) -> Encoded:
    """Combine the encodings of single frames into a batch; objects are padded."""
    counts = [_object_count(item, padding) for item in encoded]
    most = max([1, *counts])
    batch: dict[str, np.ndarray] = {}
    for name, example in encoded[0].items():
        if name not in padding:
            batch[name] = np.stack([item[name] for item in encoded])
            continue
        shape = (len(encoded), most, *example.shape[1:])
        batch[name] = np.full(shape, padding[name], example.dtype)
        for place, (item, count) in enumerate(zip(encoded, counts, strict=True)):
            batch[name][place, :count] = item[name]
    return batch


def load_encodings(
    frames: Frames,
    learner_spec: LearnerSpec,
    *,
    workers: int = 1,
    on_progress: ProgressCallback | None = None,
) -> Encodings:
    """Return a cached learner's encodings of frames; encodes the missing episodes.

    Args:
        frames: The frames to encode.
        learner_spec: The learner.
        workers: Number of processes that encode.
        on_progress: Called with the number of finished episodes and their total number.

    Raises:
        InputError: Frames cannot be encoded, or a pack is broken.
    """
    key = encodings_key(learner_spec, frames.targets)
    folders: dict[Path, dict[str, _Task]] = defaultdict(dict)
    for place, number in frames.routes:
        source = frames.sources[place]
        task = _Task(learner_spec, source.data, source.pack.folder, number, frames.targets)
        folder = source.data / "encoded" / key
        folders[folder][source.pack.episodes[number].name] = task
    packs: list[ColumnStore] = []
    places: dict[tuple[Path, str], tuple[int, int, int]] = {}
    for folder, tasks in folders.items():
        for pack in open_packs(folder, tasks, EpisodeBuilder(_encode, workers, on_progress)):
            rows = np.array([episode.rows[COUNT] for episode in pack.episodes])
            for episode, first, count in zip(
                pack.episodes, start_offsets(rows)[:-1], rows, strict=True
            ):
                places[folder, episode.name] = (len(packs), int(first), int(count))
            packs.append(pack)
    return _locate(frames, learner_spec.build(), key, packs, places)


def encodings_key(learner_spec: LearnerSpec, targets: TargetKind) -> str:
    """Return the name of the folder of encodings: a hash of frames, targets, options and code."""
    learner = learner_spec.build()
    modules = learner.encoders or (type(learner).__module__,)
    code = closure_hash("plant_bench.training.frames", *modules)
    options = json.dumps(learner.encoding, sort_keys=True, default=str)
    about = f"{ENCODED_FORMAT}|{frames_key()}|{targets}|{learner.name}|{options}|{code}"
    return hashlib.sha256(about.encode()).hexdigest()[:KEY_LENGTH]


def _locate(
    frames: Frames,
    learner: Learner,
    key: str,
    packs: list[ColumnStore],
    places: dict[tuple[Path, str], tuple[int, int, int]],
) -> Encodings:
    """Find each frame's pack and row."""
    pack, row, at = np.zeros(len(frames), np.int64), np.zeros(len(frames), np.int64), 0
    sizes = _episode_sizes(frames)
    for (place, number), size in sizes.items():
        source = frames.sources[place]
        folder = source.data / "encoded" / key
        pack_index, first, count = places[folder, source.pack.episodes[number].name]
        if count != size:
            message = f"Broken pack: {packs[pack_index].folder}. Remove it; it is rebuilt."
            raise InputError(message)
        pack[at : at + size], row[at : at + size] = pack_index, np.arange(first, first + size)
        at += size
    starts = tuple(start_offsets(item.columns[COUNT]) for item in packs)
    return Encodings(dict(learner.padding), tuple(packs), pack, row, starts)


def _episode_sizes(frames: Frames) -> dict[tuple[int, int], int]:
    """Return the number of frames by (source, episode), in the order of the frames."""
    ends = start_offsets(np.array([len(source.pack.episodes) for source in frames.sources]))
    numbers = ends[frames.source] + frames.episode
    counts = np.bincount(numbers, minlength=int(ends[-1]))
    return {place: int(counts[ends[place[0]] + place[1]]) for place in frames.routes}


@dataclass(frozen=True)
class _Task:
    learner_spec: LearnerSpec
    data: Path
    pack: Path
    number: int
    targets: TargetKind


def _encode(task: _Task) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    source, learner = _episodes(task.data, task.pack), task.learner_spec.build()
    first, end = source.first_frames[task.number : task.number + 2].tolist()
    disturbed = source.pack.columns["disturbed"]
    rows = [
        row for row in range(first, end) if task.targets == "expert-action" or not disturbed[row]
    ]
    encoded = [
        learner.encode(source.frame(task.number, row, targets=task.targets, inputs=learner.inputs))
        for row in rows
    ]
    padding = dict(learner.padding)
    counts = np.array([_object_count(item, padding) for item in encoded], np.int64)
    joint = {
        name: (np.concatenate if name in padding else np.stack)([item[name] for item in encoded])
        for name in (encoded[0] if encoded else ())
    }
    return {**joint, COUNT: counts}, {}


@lru_cache(maxsize=4)
def _episodes(data: Path, pack: Path) -> Episodes:
    return Episodes(data, open_pack(pack))


def _object_count(encoded: Encoded, padding: dict[str, float]) -> int:
    return next((len(encoded[name]) for name in padding), 0)


def _indices_within(counts: Int[np.ndarray, " parts"]) -> Int[np.ndarray, " rows"]:
    """Return the index of each row within its part: 0, 1, ... for each part."""
    starts = start_offsets(counts)
    return np.arange(starts[-1]) - np.repeat(starts[:-1], counts)
