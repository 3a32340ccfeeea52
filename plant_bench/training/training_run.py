"""Runs a training from recordings to weights, for `plant-bench train` and the Python API."""

import hashlib
import importlib.util
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from plant_bench.data.statistics import data_routes
from plant_bench.errors import InputError
from plant_bench.training.batches import Split, split_by_route
from plant_bench.training.closed_loop import ClosedLoop, check_suite
from plant_bench.training.column_store import ProgressCallback
from plant_bench.training.data_provenance import source_of
from plant_bench.training.events import Listener
from plant_bench.training.frame_store import (
    check_completeness,
    check_targets,
    load_frames,
    recordings_in,
)
from plant_bench.training.imitation import TrainingRequest, make_fabric, train
from plant_bench.training.initial_weights import check_start
from plant_bench.training.learners import LearnerSpec
from plant_bench.training.loader import make_loader
from plant_bench.training.settings import TrainingSettings


@dataclass(frozen=True)
class Machine:
    """Hardware and processes of a training; they do not change the training data.

    Attributes:
        accelerator: cpu, cuda, mps or auto.
        devices: Number of devices, one process each.
        threads: Threads of each training process; 0 for one per core.
        workers: Processes that convert episodes to frames and drive validations.
        loaders: Processes per device that encode batches that are not cached (rasters).
    """

    accelerator: str = "auto"
    devices: int = field(default=1, metadata={"min": 1, "max": 1000})
    threads: int = field(default=0, metadata={"min": 0, "max": 10_000})
    workers: int = field(default=2, metadata={"min": 1, "max": 10_000})
    loaders: int = field(default=1, metadata={"min": 0, "max": 10_000})


@dataclass(frozen=True)
class Validation:
    """Closed-loop validation drives.

    Attributes:
        suite: Suite for validation, not one of the benchmark's; by default the held-out routes.
        routes: Selection of its routes, as in `score --routes`.
        hazards: Whether hazards are active in validation.
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
        data: Data folder with routes/ and episodes/; repeat the option for several. Towns and
            routes for validation are taken from the first.
        out: Folder for the model, e.g. models/mine.
        settings: The training settings.
        share: Share of each data folder's episodes to train on.
        start: Model folder with the initial weights.
        machine: Hardware and processes.
        validation: Closed-loop validation, if `settings.validate_every` is not 0.
        work: Folder for checkpoint, logs and validation. Default: reports/training-NAME-HASH, with
            the name of the model folder and a hash of its whole path.
        overwrite: Start anew instead of resuming.
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
    def learner_spec(self) -> LearnerSpec:
        """The learner and its options."""
        return LearnerSpec(self.learner, self.options)

    @property
    def work_folder(self) -> Path:
        """Folder of checkpoint, logs and validation runs."""
        return self.work or default_work_folder(self.out)


def default_work_folder(out: Path) -> Path:
    """Return the folder of a training's state: another one for each path of a model folder.

    >>> default_work_folder(Path("/one/mine")) == default_work_folder(Path("/two/mine"))
    False
    """
    whole = Path(os.path.abspath(out))  # noqa: PTH100  a link's own path, not that of its target
    digest = hashlib.sha256(os.fsencode(whole)).hexdigest()[:8]
    return Path("reports") / f"training-{whole.name}-{digest}"


@dataclass(frozen=True)
class Listeners:
    """Callbacks that report the progress of a training.

    Attributes:
        on_frames: Called for each episode converted to frames.
        on_encodings: Called for each encoded episode.
        on_split: Called once with the training and validation sets.
        on_event: Called with each event of the training.
    """

    on_frames: ProgressCallback | None = None
    on_encodings: ProgressCallback | None = None
    on_split: Callable[[Split], None] | None = None
    on_event: Listener = lambda _event: None


SILENT = Listeners()


def run_training(run: TrainingRun, listeners: Listeners = SILENT) -> bool:
    """Train to the end; return False if Ctrl-C ended the training.

    The same call resumes an interrupted training.

    Raises:
        InputError: Data or a folder cannot be used, or the folder holds another training.
        TrainingError: The loss is not finite.
    """
    machine = run.machine
    check_training_run(run)
    if machine.threads:
        torch.set_num_threads(machine.threads)
    try:
        split = _split(run, listeners)
        # Before Fabric starts other processes, which would encode the same:
        loader = make_loader(
            split.frames,
            run.learner_spec,
            loaders=machine.loaders,
            workers=machine.workers,
            on_progress=listeners.on_encodings,
        )
        fabric = make_fabric(accelerator=machine.accelerator, devices=machine.devices)
        request = TrainingRequest(
            run.learner_spec,
            run.settings,
            run.out,
            run.work_folder,
            _closed_loop(run, split),
            run.overwrite,
            run.start,
            _sources(run),
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


def check_training_run(run: TrainingRun) -> None:
    """Check a training's settings and folders before any data is converted.

    Raises:
        InputError: The training cannot run.
    """
    if importlib.util.find_spec("lightning_fabric") is None:
        message = (
            "Training needs Lightning Fabric: pip install '.[train]' in a checkout of plant-bench."
        )
        raise InputError(message)
    if run.settings.patience and not run.settings.validate_every:
        message = "--patience counts closed-loop validations: --validate-every must be set, too."
        raise InputError(message)
    learner = run.learner_spec.build()
    if run.start is not None:
        check_start(learner, run.start)
    if run.validation.suite is not None:
        check_suite(run.validation.suite)
    for folder in run.data:
        check_completeness(folder)
        check_targets(folder, run.settings.targets)


def _split(run: TrainingRun, listeners: Listeners) -> Split:
    settings = run.settings
    frames = load_frames(
        run.data,
        targets=settings.targets,
        share=run.share,
        workers=run.machine.workers,
        on_progress=listeners.on_frames,
    )
    return split_by_route(frames, settings.held_out, settings.seed, settings.stationary_fraction)


def _closed_loop(run: TrainingRun, split: Split) -> ClosedLoop | None:
    validation = run.validation
    if not run.settings.validate_every:
        return None
    first = run.data[0]
    routes = validation.routes
    if validation.suite is None and routes is None:
        routes = ",".join(_held_out_in(first, split))
    suite = validation.suite or str(first / "routes")
    return ClosedLoop(suite, routes, validation.hazards, run.machine.workers)


def _held_out_in(data: Path, split: Split) -> list[str]:
    """Return the held-out routes that are in a data folder; others may be in other folders."""
    known = data_routes(data)
    found = [name for name in split.held_out if name in known]
    if not found:
        message = (
            f"None of the held-out routes is in {data / 'routes'}, the first data folder, which "
            "validation uses. Hold out more routes (--held-out), give the largest folder first, or "
            "give a suite (--validate-suite)."
        )
        raise InputError(message)
    return found


def _sources(run: TrainingRun) -> tuple[str, ...]:
    counts = [len(recordings_in(folder, run.share)) for folder in run.data]
    return tuple(map(source_of, run.data, counts))
