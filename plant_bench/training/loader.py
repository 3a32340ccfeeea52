"""Loads the batches of a training, from memory-mapped encodings or encoded by worker processes.

Both give the same order, and can resume at any step of an epoch.
"""

import signal
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
import torch
from jaxtyping import Int
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from plant_bench.errors import InputError
from plant_bench.learner import Encoded
from plant_bench.training.column_store import Progress
from plant_bench.training.encodings import Encodings, load_encodings, stacked
from plant_bench.training.frame_store import Frames
from plant_bench.training.learners import Student

AHEAD = 2  # batches that each process of the loaders has ready

Tensors = dict[str, Tensor]


@runtime_checkable
class Loader(Protocol):
    """Gives batches of frames.

    Attributes:
        counts: Of each frame, the number of its objects: those with like numbers are put together.
        waited: Seconds for which batches were waited for.
    """

    counts: Int[np.ndarray, " frames"]
    waited: float

    def batches(self, chosen: Sequence[np.ndarray]) -> Iterator[Tensors]:
        """Give a batch for each of some lists of frames, in order."""
        ...

    def close(self) -> None:
        """End what it has started."""
        ...


def make_loader(
    frames: Frames,
    student: Student,
    *,
    loaders: int = 1,
    workers: int = 1,
    on_progress: Progress | None = None,
) -> Loader:
    """Return what gives the batches of a learner.

    Args:
        frames: All that batches are made of.
        student: Who learns.
        loaders: Processes that encode batches; 0 for none but this one.
        workers: Processes that make encodings that are kept.
        on_progress: Told how many of how many episodes are encoded.

    Raises:
        InputError: Frames cannot be encoded.
    """
    if student.learner().cached:
        return MappedLoader(
            load_encodings(frames, student, workers=workers, on_progress=on_progress)
        )
    return EncodingLoader(frames, student, loaders)


class MappedLoader:
    """Takes batches from encodings on disk; mutable.

    Args:
        encodings: Of all frames.
    """

    def __init__(self, encodings: Encodings) -> None:
        self._encodings = encodings
        self.counts = encodings.counts
        self.waited = 0.0

    def batches(self, chosen: Sequence[np.ndarray]) -> Iterator[Tensors]:
        """Give a batch for each of some lists of frames, in order."""
        for frames in chosen:
            begin = time.perf_counter()
            batch = _tensors(self._encodings.batch(frames))
            self.waited += time.perf_counter() - begin
            yield batch

    def close(self) -> None:
        """Nothing was started."""


class EncodingLoader:
    """Has batches encoded anew each time, by processes of their own; mutable.

    They are spawned, so that no lock of torch's or SUMO's threads is copied, and map the frames
    themselves. They live until `close`.

    Args:
        frames: All that batches are made of.
        student: Who encodes them.
        loaders: How many processes; 0 for none but this one.
    """

    def __init__(self, frames: Frames, student: Student, loaders: int) -> None:
        self._frames = FramesOf(frames, student)
        self._loaders = loaders
        self._order = _Order()
        self._loader: DataLoader | None = None
        self.counts = np.zeros(len(frames), np.int64)
        self.waited = 0.0

    def batches(self, chosen: Sequence[np.ndarray]) -> Iterator[Tensors]:
        """Give a batch for each of some lists of frames, in order."""
        if self._loaders == 0:
            given: Iterator[Tensors | _Refused] = (self._frames[frames] for frames in chosen)
        else:
            self._order.batches = list(chosen)
            given = iter(self._started())
        while True:
            begin = time.perf_counter()
            batch = next(given, None)
            self.waited += time.perf_counter() - begin
            if isinstance(batch, _Refused):
                raise InputError(batch.message)
            if batch is None:
                return
            yield batch

    def close(self) -> None:
        """End the processes."""
        self._loader = None

    def _started(self) -> DataLoader:
        if self._loader is None:
            self._loader = DataLoader(
                self._frames,
                batch_size=None,
                sampler=self._order,
                num_workers=self._loaders,
                prefetch_factor=AHEAD,
                multiprocessing_context="spawn",
                generator=torch.Generator(),  # its own: the training's numbers stay as they are
                persistent_workers=True,
                worker_init_fn=_leave_ctrl_c,
            )
        return self._loader


class FramesOf(Dataset):
    """Encodes lists of frames as batches.

    Args:
        frames: All that there are.
        student: Who encodes them.
    """

    def __init__(self, frames: Frames, student: Student) -> None:
        self._frames, self._student = frames, student
        self._learner: Any = None

    def __getitem__(self, chosen: np.ndarray) -> "Tensors | _Refused":
        """Return a batch; what is wrong with the input is told, since errors get a traceback."""
        try:
            return self._batch(chosen)
        except InputError as error:
            return _Refused(str(error))

    def _batch(self, chosen: np.ndarray) -> Tensors:
        learner = self._learner
        if learner is None:
            learner = self._learner = self._student.learner()
        encoded = [learner.encode(self._frames.frame(at, learner.inputs)) for at in chosen.tolist()]
        return _tensors(stacked(encoded, dict(learner.padding)))

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what cannot be sent."""
        return {**vars(self), "_learner": None}


@dataclass(frozen=True)
class _Refused:
    message: str


def _leave_ctrl_c(_worker: int) -> None:
    """Ignore Ctrl-C in loader processes: the training still needs its batches."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class _Order:
    """The lists of frames that are wanted next; mutable."""

    def __init__(self) -> None:
        self.batches: list[np.ndarray] = []

    def __iter__(self) -> Iterator[np.ndarray]:
        return iter(self.batches)

    def __len__(self) -> int:
        return len(self.batches)


def _tensors(batch: Encoded) -> Tensors:
    return {name: torch.from_numpy(values) for name, values in batch.items()}
