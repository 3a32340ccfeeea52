"""Trains and drives each variant of a base.

OUT/<training>/seed-N/model       the weights, with a card
OUT/<training>/seed-N/training    checkpoint and logs
OUT/<training>/seed-N/run         an ordinary run of `plant-bench score`
OUT/<training>/seed-N/done.json   what the finished weights were trained as, and on what
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
    """Request of an ablation study.

    Attributes:
        names: Names of the ablations; empty for all.
        base: The recipe that they change.
        data: Folders of the recordings.
        out: Output folder.
        drives: The evaluation run; its agent is ignored.
        seeds: Number of trainings of each variant.
        machine: Hardware and processes.
        overwrite: Repeat finished trainings and runs.
        graph: Drive with the learner's fast form, see `Learner.for_driving`.
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
class Helpers:
    """Callbacks of an ablation study.

    Attributes:
        learn: Trains; returns False if it was stopped.
        drive: Drives the missing episodes of a run; returns None if it was stopped.
        tell: Called with the name of the current training.
    """

    learn: Callable[[TrainingRun], bool]
    drive: Callable[[ScoreRequest, Path], Run | None]
    tell: Callable[[str], None]


def run_ablations(request: AblationRequest, helpers: Helpers) -> Runs | None:
    """Train and score every variant; None if it was stopped.

    Returns:
        The runs of each training, one per seed.

    Raises:
        PlantBenchError: A training or a run cannot be started or cannot go on.
    """
    variants = variants_of(request.names, request.base)
    recordings_of(request.data)
    select_routes(load_suite(request.drives.suite), request.drives.routes)  # better now than later
    density_of(request.drives.density)
    RunFolder(request.out).make_subfolder("")
    runs: Runs = {}
    for name, recipe in trainings_of(variants).items():
        runs[name] = []
        for seed in range(request.seeds):
            helpers.tell(f"{name}, seed {seed}:")
            run = _train_and_drive(request, helpers, recipe, seed, request.out / name)
            if run is None:
                return None
            runs[name].append(run)
    return runs


def recordings_of(data: tuple[Path, ...], share: float = 1.0) -> list[Path]:
    """Return the recordings of some folders.

    Raises:
        InputError: A folder has none.
    """
    return [path for folder in data for path in recordings_in(folder, share)]


def _train_and_drive(
    request: AblationRequest, helpers: Helpers, recipe: Recipe, seed: int, folder: Path
) -> Run | None:
    """Train a variant and score it; None if it was stopped."""
    place = folder / f"seed-{seed}"
    seeded = replace(recipe, settings=replace(recipe.settings, seed=seed))
    if not _train(request, helpers, seeded, place):
        return None
    agent = f"{recipe.student.learner().agent}@{place / 'model'}"
    with threads_kept():
        run = helpers.drive(replace(request.drives, agent=agent), place / "run")
    if run is not None:
        write_summary(run.folder)
        write_speed(run.folder, map(episode_name, run.jobs))
    return run


def _train(request: AblationRequest, helpers: Helpers, recipe: Recipe, place: Path) -> bool:
    """Train what is not finished; False if it was stopped.

    Raises:
        InputError: The folder holds weights of another training, or the data cannot be used.
    """
    done = place / DONE
    about = _training_text(request.data, recipe)
    if done.is_file() and (place / "model" / WEIGHTS_FILE).is_file() and not request.overwrite:
        if done.read_bytes() == about.encode():
            return True
        message = (
            f"{place} holds weights that were trained otherwise or on other data (see {done}). "
            "Ask for the same, choose another folder with --out, or give --overwrite."
        )
        raise InputError(message)
    finished = helpers.learn(_course(request, recipe, place))
    if finished:
        RunFolder(place).write(DONE, about)
    return finished


def _course(request: AblationRequest, recipe: Recipe, place: Path) -> TrainingRun:
    student = recipe.student
    return TrainingRun(
        student.spec,
        student.learner().for_driving() if request.graph else student.options,
        request.data,
        place / "model",
        recipe.settings,
        recipe.share,
        machine=request.machine,
        work=place / "training",
        overwrite=request.overwrite,
    )


def _training_text(data: tuple[Path, ...], recipe: Recipe) -> str:
    """Return what a training depends on as text: equal where it need not be made again."""
    names = [f"{path.name} {path.stat().st_size}" for path in recordings_of(data, recipe.share)]
    about = {
        "learner": recipe.student.spec,
        "options": recipe.student.learner().recipe,
        "settings": asdict(recipe.settings),
        "share": recipe.share,
        "recordings": len(names),
        "hash": hashlib.sha256("\n".join(names).encode()).hexdigest(),
    }
    return json.dumps(about, indent=1, default=str) + "\n"
