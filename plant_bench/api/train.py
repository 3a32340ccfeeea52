"""Training a planner from collected data."""

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
    """Train a planner to imitate what was recorded, and return the model's folder.

    The same call again goes on where it was interrupted, and comes to the same weights.

    Args:
        learner: A name ("plant"), "package.module:Class", "file.py:Class", or a class of a module:
            a `plant_bench.learner.Learner`.
        data: Folders that `collect` filled.
        out: Folder for the model; `score(f"plant@{out}")` drives with it.
        options: The learner's own, of its `Options`; its defaults without them.
        settings: Epochs, batch, rate and the like; the paper's without them.
        share: Of each folder's episodes, the first.
        start: Model to start from.
        machine: Accelerator, processes, threads.
        work: Folder for checkpoint and logs; `reports/training-NAME` without it.
        overwrite: Start anew instead of going on.
        on_event: Told of steps and epochs (`plant_bench.training.events`).

    Raises:
        InputError: Data or a folder cannot be used, or the folder holds another training.
        KeyboardInterrupt: It was stopped; the same call goes on.
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
            f"{learner} is not found by other processes: put the class into a file, and give "
            "'file.py:Class'."
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
