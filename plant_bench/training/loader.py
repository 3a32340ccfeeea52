"""Loads the batches of a training: from cached encodings, or encoded on the fly by processes.

Both yield batches in the requested order, so a training can resume at any step of an epoch.
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
from plant_bench.training.column_store import ProgressCallback
from plant_bench.training.encodings import Encodings, load_encodings, stack_encodings
from plant_bench.training.frame_store import Frames
from plant_bench.training.learners import LearnerSpec

PREFETCHED = 2  # batches that each loader process prepares in advance

Tensors = dict[str, Tensor]


@runtime_checkable
class Loader(Protocol):
    """Loads batches of frames.

    Attributes:
        counts: Number of objects of each frame, by which samples are sorted; 0 if unknown.
        waited: Total time spent waiting for batches, seconds.
    """

    counts: Int[np.ndarray, " frames"]
    waited: float

    def batches(self, chosen: Sequence[np.ndarray]) -> Iterator[Tensors]:
        """Give a batch for each of some lists of frames, in order."""
        ...

    def close(self) -> None:
        """End the loader's processes."""
        ...


def make_loader(
    frames: Frames,
    learner_spec: LearnerSpec,
    *,
    loaders: int = 1,
    workers: int = 1,
    on_progress: ProgressCallback | None = None,
) -> Loader:
    """Return the loader that suits a learner.

    Args:
        frames: All frames.
        learner_spec: The learner.
        loaders: Processes that encode batches if the learner is not cached; 0 for this process.
        workers: Processes that compute the encodings to cache.
        on_progress: Called with the number of encoded episodes and their total number.

    Raises:
        InputError: Frames cannot be encoded.
    """
    if learner_spec.build().cached:
        return MappedLoader(
            load_encodings(frames, learner_spec, workers=workers, on_progress=on_progress)
        )
    return EncodingLoader(frames, learner_spec, loaders)


class MappedLoader:
    """Reads batches from cached encodings; mutable.

    Args:
        encodings: The encodings of all frames.
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
        """Do nothing: there are no processes."""


class EncodingLoader:
    """Encodes batches on the fly in separate processes; mutable.

    The processes are spawned, since a fork would copy locks of torch's and SUMO's threads. Each
    maps the frames itself, and runs until `close`.

    Args:
        frames: All frames.
        learner_spec: The learner.
        loaders: Number of processes; 0 to encode in this one.
    """

    def __init__(self, frames: Frames, learner_spec: LearnerSpec, loaders: int) -> None:
        self._frames = FrameDataset(frames, learner_spec)
        self._loaders = loaders
        self._sampler = _BatchSampler()
        self._loader: DataLoader | None = None
        self.counts = np.zeros(len(frames), np.int64)
        self.waited = 0.0

    def batches(self, chosen: Sequence[np.ndarray]) -> Iterator[Tensors]:
        """Give a batch for each of some lists of frames, in order."""
        if self._loaders == 0:
            loaded: Iterator[Tensors | _EncodingError] = (self._frames[frames] for frames in chosen)
        else:
            self._sampler.batches = list(chosen)
            loaded = iter(self._start())
        while True:
            begin = time.perf_counter()
            batch = next(loaded, None)
            self.waited += time.perf_counter() - begin
            if isinstance(batch, _EncodingError):
                raise InputError(batch.message)
            if batch is None:
                return
            yield batch

    def close(self) -> None:
        """End the processes."""
        self._loader = None

    def _start(self) -> DataLoader:
        if self._loader is None:
            self._loader = DataLoader(
                self._frames,
                batch_size=None,
                sampler=self._sampler,
                num_workers=self._loaders,
                prefetch_factor=PREFETCHED,
                multiprocessing_context="spawn",
                generator=torch.Generator(),  # leaves the training's random state untouched
                persistent_workers=True,
                worker_init_fn=_ignore_interrupts,
            )
        return self._loader


class FrameDataset(Dataset):
    """A torch dataset whose items are whole batches, by the frames in them.

    Args:
        frames: All frames.
        learner_spec: The learner.
    """

    def __init__(self, frames: Frames, learner_spec: LearnerSpec) -> None:
        self._frames, self._learner_spec = frames, learner_spec
        self._learner: Any = None

    def __getitem__(self, chosen: np.ndarray) -> "Tensors | _EncodingError":
        """Return a batch; an InputError is returned, since torch adds a traceback to exceptions."""
        try:
            return self._batch(chosen)
        except InputError as error:
            return _EncodingError(str(error))

    def _batch(self, chosen: np.ndarray) -> Tensors:
        learner = self._learner
        if learner is None:
            learner = self._learner = self._learner_spec.build()
        encoded = [learner.encode(self._frames.frame(at, learner.inputs)) for at in chosen.tolist()]
        return _tensors(stack_encodings(encoded, dict(learner.padding)))

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the learner, which may not be picklable."""
        return {**vars(self), "_learner": None}


@dataclass(frozen=True)
class _EncodingError:
    message: str


def _ignore_interrupts(_worker: int) -> None:
    """Ignore Ctrl-C in loader processes: the training still needs its batches."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class _BatchSampler:
    """Yields the frames of each requested batch; mutable."""

    def __init__(self) -> None:
        self.batches: list[np.ndarray] = []

    def __iter__(self) -> Iterator[np.ndarray]:
        return iter(self.batches)

    def __len__(self) -> int:
        return len(self.batches)


def _tensors(batch: Encoded) -> Tensors:
    return {name: torch.from_numpy(values) for name, values in batch.items()}
