"""What `plant-bench train` shows of a course while it is taken."""

import typer

from plant_bench.cli.training_progress import EpisodesProgress, TrainingProgress, bars
from plant_bench.training.batches import Split
from plant_bench.training.course import Course, Listeners, learn
from plant_bench.training.logs import NO_TENSORBOARD, has_tensorboard


def learn_visibly(course: Course) -> bool:
    """Train to the end; False if Ctrl-C ended it.

    Raises:
        InputError: Data or a folder cannot be used, or the folder holds another training.
    """
    with bars() as shown:
        finished = learn(
            course,
            Listeners(
                on_frames=EpisodesProgress(shown, "episodes made into frames"),
                on_encodings=EpisodesProgress(shown, "episodes encoded"),
                on_split=introduce,
                on_event=TrainingProgress(shown, course.settings.epochs),
            ),
        )
    if not finished:
        typer.echo("Stopped. The same command goes on from here.", err=True)
    else:
        typer.echo(f"Model: {course.out}")
    return finished


def introduce(split: Split) -> None:
    """Say what there is to learn from."""
    typer.echo(
        f"{len(split.training)} samples to learn from, {len(split.validation)} of "
        f"{len(split.held_out)} other routes to check with.",
        err=True,
    )
    if not has_tensorboard():
        typer.echo(NO_TENSORBOARD, err=True)
