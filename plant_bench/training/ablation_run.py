"""Trains and scores every variant of an ablation study.

OUT/<training>/seed-N/model       the weights, with a card
OUT/<training>/seed-N/training    checkpoint and logs
OUT/<training>/seed-N/run         an ordinary run of `plant-bench score`
OUT/<training>/seed-N/done.json   settings and data of the finished training
"""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.model_folder import WEIGHTS_FILE
from plant_bench.runner.episode.jobs import episode_name, select_routes
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.score_run import Run, ScoreRequest
from plant_bench.runner.run.speed import write_speed
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.sim.densities import density_of
from plant_bench.training.ablation_variants import Recipe, trainings_of, variants_of
from plant_bench.training.frame_store import recordings_in
from plant_bench.training.threads import threads_kept
from plant_bench.training.training_run import Machine, TrainingRun
from plant_bench.world.route import load_suite

DONE = "done.json"

Runs = dict[str, list[Run]]


@dataclass(frozen=True)
class AblationRequest:
    """Settings of an ablation study.

    Attributes:
        names: Names of the ablations; empty for all.
        base: The recipe that the variants change.
        data: Folders of the recordings.
        out: Output folder.
        drives: Request of the evaluation runs; its agent is ignored.
        seeds: Number of trainings of each variant.
        machine: Hardware and processes.
        overwrite: Repeat finished trainings and runs.
        graph: Export the models in the learner's fast form, see `Learner.for_driving`.
    """

    names: Sequence[str]
    base: Recipe
    data: tuple[Path, ...]
    out: Path
    drives: ScoreRequest
    seeds: int
    machine: Machine
    overwrite: bool = False
    graph: bool = False


@dataclass(frozen=True)
class AblationCallbacks:
    """Callbacks of an ablation study.

    Attributes:
        train: Runs a training; returns False if it was interrupted.
        drive: Drives the missing episodes of a run; returns None if it was interrupted.
        on_training: Called with the name of each training before it starts.
    """

    train: Callable[[TrainingRun], bool]
    drive: Callable[[ScoreRequest, Path], Run | None]
    on_training: Callable[[str], None]


def run_ablations(request: AblationRequest, callbacks: AblationCallbacks) -> Runs | None:
    """Train and score every variant.

    Returns:
        The runs of each training, one per seed; None if the study was interrupted.

    Raises:
        PlantBenchError: A training or a run cannot start or continue.
    """
    variants = variants_of(request.names, request.base)
    recordings_in_all(request.data)
    select_routes(load_suite(request.drives.suite), request.drives.routes)  # fails early
    density_of(request.drives.density)
    RunFolder(request.out).make_subfolder("")
    runs: Runs = {}
    for name, recipe in trainings_of(variants).items():
        runs[name] = []
        for seed in range(request.seeds):
            callbacks.on_training(f"{name}, seed {seed}:")
            run = _train_and_drive(request, callbacks, recipe, seed, request.out / name)
            if run is None:
                return None
            runs[name].append(run)
    return runs


def recordings_in_all(data: tuple[Path, ...], share: float = 1.0) -> list[Path]:
    """Return the recordings of several data folders, see `recordings_in`.

    Raises:
        InputError: A folder has no recordings.
    """
    return [path for folder in data for path in recordings_in(folder, share)]


def _train_and_drive(
    request: AblationRequest, callbacks: AblationCallbacks, recipe: Recipe, seed: int, folder: Path
) -> Run | None:
    """Train a variant and score it; return None if it was interrupted."""
    seed_folder = folder / f"seed-{seed}"
    seeded = replace(recipe, settings=replace(recipe.settings, seed=seed))
    if not _train(request, callbacks, seeded, seed_folder):
        return None
    agent = f"{recipe.learner.build().agent}@{seed_folder / 'model'}"
    with threads_kept():
        run = callbacks.drive(replace(request.drives, agent=agent), seed_folder / "run")
    if run is not None:
        write_summary(run.folder)
        write_speed(run.folder, map(episode_name, run.jobs))
    return run


def _train(
    request: AblationRequest, callbacks: AblationCallbacks, recipe: Recipe, folder: Path
) -> bool:
    """Train a variant unless it is finished; return False if the training was interrupted.

    Raises:
        InputError: The folder holds weights of another training, or the data cannot be used.
    """
    done = folder / DONE
    description = _training_description(request.data, recipe)
    if done.is_file() and (folder / "model" / WEIGHTS_FILE).is_file() and not request.overwrite:
        if done.read_bytes() == description.encode():
            return True
        message = (
            f"{folder} holds weights trained with other settings or on other data (see {done}). "
            "Use the same settings and data, another folder (--out), or --overwrite."
        )
        raise InputError(message)
    finished = callbacks.train(_training_run(request, recipe, folder))
    if finished:
        RunFolder(folder).write(DONE, description)
    return finished


def _training_run(request: AblationRequest, recipe: Recipe, folder: Path) -> TrainingRun:
    learner = recipe.learner
    return TrainingRun(
        learner.name,
        learner.build().for_driving() if request.graph else learner.options,
        request.data,
        folder / "model",
        recipe.settings,
        recipe.share,
        machine=request.machine,
        work=folder / "training",
        overwrite=request.overwrite,
    )


def _training_description(data: tuple[Path, ...], recipe: Recipe) -> str:
    """Return the settings and data of a training as JSON; equal text means equal trainings."""
    names = [f"{path.name} {path.stat().st_size}" for path in recordings_in_all(data, recipe.share)]
    description = {
        "learner": recipe.learner.name,
        "options": recipe.learner.build().recipe,
        "settings": asdict(recipe.settings),
        "share": recipe.share,
        "recordings": len(names),
        "hash": hashlib.sha256("\n".join(names).encode()).hexdigest(),
    }
    return json.dumps(description, indent=1, default=str) + "\n"
