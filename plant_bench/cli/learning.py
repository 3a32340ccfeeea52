"""What `plant-bench train` does: make samples, train, and show how it goes."""

from dataclasses import dataclass
from pathlib import Path

import torch
import typer

from plant_bench.agents.plant.config import GraphBits, load_config
from plant_bench.cli.training_progress import SamplesProgress, TrainingProgress, bars
from plant_bench.data.statistics import data_routes
from plant_bench.errors import InputError
from plant_bench.training.ablations import Recipe
from plant_bench.training.batches import Split, split_by_route
from plant_bench.training.closed_loop import ClosedLoop, check_suite
from plant_bench.training.imitation import TrainingRequest, make_fabric, train
from plant_bench.training.logs import NO_TENSORBOARD, has_tensorboard
from plant_bench.training.shards import check_targets, load_shards, recordings_in
from plant_bench.training.sources import source_of
from plant_bench.training.trainer import check_start


@dataclass(frozen=True)
class Machine:
    """What a training runs on.

    Attributes:
        accelerator: cpu, cuda, mps or auto.
        devices: Processes, one a device.
        threads: Of each process; 0 for one a core.
        workers: Processes that make samples and drive validations.
    """

    accelerator: str = "auto"
    devices: int = 1
    threads: int = 0
    workers: int = 2


@dataclass(frozen=True)
class Validation:
    """What is driven for validation.

    Attributes:
        suite: A suite's name, or a folder or file of routes; None for the routes of the data.
        routes: Selection of them; None for all of a suite, or those of the data held out.
        hazards: Whether their hazards are played.
    """

    suite: str | None
    routes: str | None
    hazards: bool


@dataclass(frozen=True)
class Course:
    """One training, from recordings to weights.

    Attributes:
        recipe: What to train.
        data: Folders of the recordings; towns and routes for validation are the first one's.
        out: Folder for the model.
        work: Folder for checkpoint, logs and validation runs.
        machine: What it runs on.
        validation: What is driven where the settings say so.
        overwrite: Start anew instead of going on.
        graph: Bits of the weights in the ONNX graph to be written, too; None for no graph.
        start: Folder of the weights to start from, if not from chance.
    """

    recipe: Recipe
    data: tuple[Path, ...]
    out: Path
    work: Path
    machine: Machine
    validation: Validation | None = None
    overwrite: bool = False
    graph: GraphBits | None = None
    start: Path | None = None


def learn(course: Course) -> bool:
    """Train to the end; False if Ctrl-C ended it.

    Raises:
        InputError: Data or a folder cannot be used, or the folder holds another training.
    """
    settings, machine = course.recipe.settings, course.machine
    if machine.threads:
        torch.set_num_threads(machine.threads)
    # better now than when all samples are made:
    if course.start is not None:
        check_start(load_config(course.start), course.recipe.config)
    if course.validation is not None and course.validation.suite is not None:
        check_suite(course.validation.suite)
    try:
        split = _split(course)
        fabric = make_fabric(accelerator=machine.accelerator, devices=machine.devices)
        request = TrainingRequest(
            course.recipe.config,
            settings,
            course.out,
            course.work,
            _closed_loop(course, split),
            course.overwrite,
            course.graph,
            course.start,
            _sources(course),
        )
        if fabric.is_global_zero:
            _introduce(split)
        with bars() as shown:
            train(request, split, fabric, TrainingProgress(shown, settings.epochs))
    except KeyboardInterrupt:
        typer.echo("Stopped. The same command goes on from here.", err=True)
        return False
    if fabric.is_global_zero:
        typer.echo(f"Model: {course.out}")
    return True


def _split(course: Course) -> Split:
    recipe = course.recipe
    for folder in course.data:
        recordings_in(folder)
        check_targets(folder, recipe.settings.targets)
    with bars() as shown:
        shards = [
            shard
            for folder in course.data
            for shard in load_shards(
                folder,
                recipe.config.tokens,
                targets=recipe.settings.targets,
                share=recipe.share,
                workers=course.machine.workers,
                on_progress=SamplesProgress(shown),
            )
        ]
    settings = recipe.settings
    return split_by_route(shards, settings.held_out, settings.seed, settings.resting)


def _closed_loop(course: Course, split: Split) -> ClosedLoop | None:
    asked = course.validation
    if asked is None or not course.recipe.settings.validate_every:
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


def _sources(course: Course) -> tuple[str, ...]:
    counts = [len(recordings_in(folder, course.recipe.share)) for folder in course.data]
    return tuple(map(source_of, course.data, counts))


def _introduce(split: Split) -> None:
    typer.echo(
        f"{len(split.training)} samples to learn from, {len(split.validation)} of "
        f"{len(split.held_out)} other routes to check with.",
        err=True,
    )
    if not has_tensorboard():
        typer.echo(NO_TENSORBOARD, err=True)
