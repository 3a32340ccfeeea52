"""Trains a planner on collected data and writes its model folder."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plant_bench.api.planners import importable_name
from plant_bench.errors import InputError

if TYPE_CHECKING:  # these load torch
    from plant_bench.learner import Learner
    from plant_bench.training.events import Listener
    from plant_bench.training.settings import TrainingSettings
    from plant_bench.training.training_run import Machine

PathLike = str | os.PathLike[str]


def train(
    learner: "str | type[Learner]",
    data: PathLike | Sequence[PathLike],
    out: PathLike,
    *,
    options: Any = None,
    settings: "TrainingSettings | None" = None,
    share: float = 1.0,
    start: PathLike | None = None,
    machine: "Machine | None" = None,
    work: PathLike | None = None,
    overwrite: bool = False,
    on_event: "Listener | None" = None,
) -> Path:
    """Train a planner by imitation of recorded episodes; return the model folder.

    The same call again resumes an interrupted training and gives the same weights.

    Args:
        learner: A `plant_bench.learner.Learner`: a name ("plant"), "package.module:Class",
            "file.py:Class", or a class of a module.
        data: Data folders written by `collect`.
        out: Model folder to write; `score(f"plant@{out}")` drives it.
        options: An instance of the learner's `Options`. Default: `Options()`.
        settings: Epochs, batch size, learning rate and so on. Default: those of the PlanT paper.
        share: Fraction of each folder's episodes to train on, 0 to 1; the first ones are used.
        start: Model folder with the initial weights.
        machine: Accelerator, number of processes and threads.
        work: Folder for checkpoints and logs. Default: `reports/training-NAME-HASH`, with
            the name of `out` and a hash of its whole path.
        overwrite: Start again instead of resuming.
        on_event: Called with events such as steps and epochs (`plant_bench.training.events`).

    Raises:
        InputError: Data or a folder cannot be used, or the folder belongs to another training.
        TrainingError: The loss is not finite (`plant_bench.training.divergence`).
        KeyboardInterrupt: Ctrl-C was pressed; the same call resumes.
    """
    from plant_bench.training.learners import learner_class
    from plant_bench.training.settings import TrainingSettings
    from plant_bench.training.training_run import (
        SILENT,
        Listeners,
        Machine,
        TrainingRun,
        run_training,
    )

    name = learner if isinstance(learner, str) else importable_name(learner)
    if name is None:
        message = (
            f"learner: expected a name or a class of a module or file, got {learner}. Put the "
            "class into a file and pass 'file.py:Class'."
        )
        raise InputError(message)
    folders = [data] if isinstance(data, str | os.PathLike) else data
    run = TrainingRun(
        name,
        learner_class(name).Options() if options is None else options,
        tuple(map(Path, folders)),
        Path(out),
        settings or TrainingSettings(),
        share,
        None if start is None else Path(start),
        machine or Machine(),
        work=None if work is None else Path(work),
        overwrite=overwrite,
    )
    if not run_training(run, SILENT if on_event is None else Listeners(on_event=on_event)):
        raise KeyboardInterrupt
    return run.out
