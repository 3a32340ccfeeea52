"""Reads collected data as frames, to train a network with one's own code."""

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, overload

from plant_bench.errors import InputError
from plant_bench.learner import Frame
from plant_bench.sensing.inputs import DRIVER_ONLY, INPUTS, PERCEIVED

if TYPE_CHECKING:
    from plant_bench.training.frame_store import Frames
    from plant_bench.training.frames import TargetKind

PathLike = str | os.PathLike[str]


class RecordedFrames(Sequence[Frame]):
    """The frames of data folders; a frame is built when it is asked for.

    It can be the data set of a `torch.utils.data.DataLoader`, also one with several workers.
    """

    def __init__(self, frames: "Frames", inputs: frozenset[str]) -> None:
        self._frames, self._inputs = frames, inputs

    def __len__(self) -> int:
        return len(self._frames)

    @overload
    def __getitem__(self, number: int) -> Frame: ...

    @overload
    def __getitem__(self, number: slice) -> list[Frame]: ...

    def __getitem__(self, number: int | slice) -> Frame | list[Frame]:
        chosen = range(len(self))[number]
        if isinstance(chosen, range):
            return [self._frames.frame(row, self._inputs) for row in chosen]
        return self._frames.frame(chosen, self._inputs)

    def __iter__(self) -> Iterator[Frame]:
        return (self._frames.frame(row, self._inputs) for row in range(len(self)))


def frames(
    data: PathLike | Sequence[PathLike],
    *,
    inputs: Iterable[str] = PERCEIVED,
    targets: "TargetKind" = "future",
    workers: int = 1,
) -> RecordedFrames:
    """Return the frames of collected data, two per second, in the order of folders and episodes.

    Each is a `plant_bench.learner.Frame`: `observation` is what a planner receives when it drives,
    `answer` the expert's action, `waypoints` the ego's path in the next two seconds; `route` and
    `town` are those of the episode. The first call converts the recordings, and keeps the result in
    the folder `frames` of the data.

    Args:
        data: One or more folders written by `collect`.
        inputs: The inputs in the observations, as a planner declares them. Default: objects, route
            and traffic light.
        targets: Source of the waypoints. "future": the path that the expert drove; frames with a
            perturbation in it are left out. "expert-action": the path along the route if the
            acceleration of the expert's action is held, also for data with another driver (DAgger).
        workers: Number of processes that convert recordings.

    Raises:
        InputError: A folder or a recording cannot be used, an episode is missing or there twice, or
            an input is not in recordings.
    """
    from plant_bench.training.frame_store import check_completeness, load_frames

    wanted = frozenset(inputs)
    known = [name for name in INPUTS if name not in DRIVER_ONLY]
    if odd := sorted(str(item) for item in wanted if item not in known):
        message = (
            f"inputs: {', '.join(odd)} cannot be computed from recordings. Choose from "
            f"{', '.join(known)}."
        )
        raise InputError(message)
    folders = [data] if isinstance(data, str | os.PathLike) else data
    paths = [Path(folder) for folder in folders]
    for path in paths:
        check_completeness(path)
    return RecordedFrames(load_frames(paths, targets=targets, workers=workers), wanted)
