"""Training a planner from collected data."""

import os
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # they load torch
    from plant_bench.agents.plant.config import PlanTConfig
    from plant_bench.training.settings import TrainingSettings

COURSES = "plant_bench.cli.learning"


def train(
    data: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    config: "PlanTConfig | None" = None,
    settings: "TrainingSettings | None" = None,
    share: float = 1.0,
    start: str | os.PathLike[str] | None = None,
    accelerator: str = "auto",
    workers: int = 2,
    work: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
) -> Path:
    """Train PlanT to imitate what was recorded, and return the model's folder.

    The same call again goes on where it was interrupted, and comes to the same weights. Drive it
    with `score(f"plant@{folder}")`.

    Args:
        data: Folders that `collect` filled.
        out: Folder for the model.
        config: The network; the paper's without it.
        settings: Epochs, batch, rate and the like; the paper's without them.
        share: Of each folder's episodes, the first.
        start: Model to start from, if not from chance.
        accelerator: "cpu", "cuda", "mps" or "auto".
        workers: Processes that make samples.
        work: Folder for checkpoint and logs; `reports/training-NAME` without it.
        overwrite: Start anew instead of going on.

    Raises:
        InputError: Data or a folder cannot be used, or the folder holds another training.
        KeyboardInterrupt: It was stopped; the same call goes on.
    """
    from plant_bench.agents.plant.config import PlanTConfig
    from plant_bench.training.ablations import Recipe
    from plant_bench.training.settings import TrainingSettings

    courses: Any = import_module(COURSES)
    learn: Callable[[object], bool] = courses.learn
    folders = [data] if isinstance(data, str | os.PathLike) else data
    target = Path(out)
    course = courses.Course(
        Recipe(config or PlanTConfig(), settings or TrainingSettings(), share),
        tuple(map(Path, folders)),
        target,
        Path("reports") / f"training-{target.name}" if work is None else Path(work),
        courses.Machine(accelerator, workers=workers),
        overwrite=overwrite,
        start=None if start is None else Path(start),
    )
    if not learn(course):
        raise KeyboardInterrupt
    return target
