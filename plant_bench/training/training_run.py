"""Runs a training from recordings to weights, for `plant-bench train` and the Python API."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from plant_bench.data.statistics import data_routes
from plant_bench.errors import InputError
from plant_bench.training.batches import Split, split_by_route
from plant_bench.training.closed_loop import ClosedLoop, check_suite
from plant_bench.training.column_store import Progress
from plant_bench.training.data_provenance import source_of
from plant_bench.training.events import Listener
from plant_bench.training.frame_store import check_targets, load_frames, recordings_in
from plant_bench.training.imitation import TrainingRequest, make_fabric, train
from plant_bench.training.initial_weights import check_start
from plant_bench.training.learners import Student
from plant_bench.training.loader import make_loader
from plant_bench.training.settings import TrainingSettings


@dataclass(frozen=True)
class Machine:
    """Hardware and processes of a training; they do not change the training data.

    Attributes:
        accelerator: cpu, cuda, mps or auto.
        devices: Number of devices, one process each.
        threads: Threads of each training process; 0 for one per core.
        workers: Processes that make frames and drive validations.
        loaders: Processes for each device that make batches of what is not cached (rasters).
    """

    accelerator: str = "auto"
    devices: int = field(default=1, metadata={"min": 1})
    threads: int = field(default=0, metadata={"min": 0})
    workers: int = field(default=2, metadata={"min": 1})
    loaders: int = field(default=1, metadata={"min": 0})


@dataclass(frozen=True)
class Validation:
    """Closed-loop validation drives.

    Attributes:
        suite: Suite to drive, not one of the benchmark's; by default the held-out routes.
        routes: Selection of its routes, as in `score --routes`.
        hazards: Whether to play hazards in validation.
    """

    suite: str | None = field(default=None, metadata={"option": "validate_suite"})
    routes: str | None = field(default=None, metadata={"option": "validate_routes"})
    hazards: bool = True


@dataclass(frozen=True)
class TrainingRun:
    """One training, from recordings to weights.

    Attributes:
        learner: The learner: a name, package.module:Class or file.py:Class.
        options: Options of the learner.
        data: Folder with routes/ and episodes/; give it again for more. Towns and routes for
            validation are the first one's.
        out: Folder for the model, as models/mine.
        settings: How to train.
        share: Of each folder's episodes, the first.
        start: Model to start from.
        machine: What it runs on.
        validation: What is driven where the settings say so.
        work: Checkpoint, logs, validation; reports/training-NAME without it.
        overwrite: Start anew instead of going on.
    """

    learner: str
    options: Any
    data: tuple[Path, ...]
    out: Path
    settings: TrainingSettings = field(default_factory=TrainingSettings)
    share: float = field(default=1.0, metadata={"min": 0.001, "max": 1.0})
    start: Path | None = None
    machine: Machine = field(default_factory=Machine)
    validation: Validation = field(default_factory=Validation)
    work: Path | None = None
    overwrite: bool = False

    @property
    def student(self) -> Student:
        """Who learns."""
        return Student(self.learner, self.options)

    @property
    def work_folder(self) -> Path:
        """Where checkpoint, logs and validation runs are."""
        return self.work or Path("reports") / f"training-{self.out.name}"


@dataclass(frozen=True)
class Listeners:
    """Who is told how a course goes.

    Attributes:
        on_frames: Of episodes made into frames.
        on_encodings: Of episodes encoded.
        on_split: What there is to learn from, once that is known.
        on_event: Of the training.
    """

    on_frames: Progress | None = None
    on_encodings: Progress | None = None
    on_split: Callable[[Split], None] | None = None
    on_event: Listener = lambda _event: None


SILENT = Listeners()


def learn(course: TrainingRun, listeners: Listeners = SILENT) -> bool:
    """Train to the end; False if Ctrl-C ended it. The same course goes on where it was stopped.

    Raises:
        InputError: Data or a folder cannot be used, or the folder holds another training.
    """
    machine = course.machine
    check_course(course)
    if machine.threads:
        torch.set_num_threads(machine.threads)
    try:
        split = _split(course, listeners)
        # Before there are other processes, which would make the same:
        loader = make_loader(
            split.frames,
            course.student,
            loaders=machine.loaders,
            workers=machine.workers,
            on_progress=listeners.on_encodings,
        )
        fabric = make_fabric(accelerator=machine.accelerator, devices=machine.devices)
        request = TrainingRequest(
            course.student,
            course.settings,
            course.out,
            course.work_folder,
            _closed_loop(course, split),
            course.overwrite,
            course.start,
            _sources(course),
        )
        if listeners.on_split is not None and fabric.is_global_zero:
            listeners.on_split(split)
        try:
            train(request, split, loader, fabric, listeners.on_event)
        finally:
            loader.close()
    except KeyboardInterrupt:
        return False
    return True


def check_course(course: TrainingRun) -> None:
    """Check what can be checked before frames are made of the data.

    Raises:
        InputError: It cannot be trained like this.
    """
    if importlib.util.find_spec("lightning_fabric") is None:
        message = "Training needs Lightning Fabric: pip install 'plant-bench[train]'."
        raise InputError(message)
    if course.settings.patience and not course.settings.validate_every:
        message = "--patience counts closed-loop validations: give --validate-every, too."
        raise InputError(message)
    learner = course.student.learner()
    if course.start is not None:
        check_start(learner, course.start)
    if course.validation.suite is not None:
        check_suite(course.validation.suite)
    for folder in course.data:
        recordings_in(folder)
        check_targets(folder, course.settings.targets)


def _split(course: TrainingRun, listeners: Listeners) -> Split:
    settings = course.settings
    frames = load_frames(
        course.data,
        targets=settings.targets,
        share=course.share,
        workers=course.machine.workers,
        on_progress=listeners.on_frames,
    )
    return split_by_route(frames, settings.held_out, settings.seed, settings.stationary_fraction)


def _closed_loop(course: TrainingRun, split: Split) -> ClosedLoop | None:
    asked = course.validation
    if not course.settings.validate_every:
        return None
    first = course.data[0]
    routes = asked.routes
    if asked.suite is None and routes is None:
        routes = ",".join(_held_out_in(first, split))
    suite = asked.suite or str(first / "routes")
    return ClosedLoop(suite, routes, asked.hazards, course.machine.workers)


def _held_out_in(data: Path, split: Split) -> list[str]:
    """Return the routes held out that a folder has: others may lie in other folders alone."""
    known = data_routes(data)
    found = [name for name in split.held_out if name in known]
    if not found:
        message = (
            f"None of the routes held out is in {data / 'routes'}, where those driven for "
            "validation are taken from. Hold out more with --held-out, put the largest folder "
            "first, or say what to drive with --validate-suite."
        )
        raise InputError(message)
    return found


def _sources(course: TrainingRun) -> tuple[str, ...]:
    counts = [len(recordings_in(folder, course.share)) for folder in course.data]
    return tuple(map(source_of, course.data, counts))
