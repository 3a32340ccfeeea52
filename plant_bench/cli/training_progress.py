"""Live progress of `plant-bench train` on standard error."""

import typer
from rich.progress import MofNCompleteColumn, Progress, TaskID

from plant_bench.cli.progress import progress_bars
from plant_bench.training.batches import Split
from plant_bench.training.events import Driving, EpochEnded, StepEnded, TrainingEvent
from plant_bench.training.history import NO_TENSORBOARD, has_tensorboard
from plant_bench.training.training_run import Listeners, TrainingRun, learn

SMOOTHING = 0.98  # of the loss shown


class EpisodesProgress:
    """Follows what is made of episodes; shows nothing if nothing is to be made. Mutable.

    Args:
        bars: Are being shown.
        what: Is being made.
    """

    def __init__(self, bars: Progress, what: str) -> None:
        self._bars, self._what = bars, what
        self._task: TaskID | None = None

    def __call__(self, done: int, total: int) -> None:
        """Show how many episodes are ready."""
        if self._task is None:
            self._task = self._bars.add_task(self._what, total=total)
        self._bars.update(self._task, completed=done)


class TrainingProgress:
    """Follows a training; mutable.

    Args:
        bars: Are being shown.
        epochs: How many there will be.
    """

    def __init__(self, bars: Progress, epochs: int) -> None:
        self._bars = bars
        self._epochs = epochs
        self._loss: float | None = None
        self._whole: TaskID | None = None
        self._steps: TaskID | None = None

    def __call__(self, event: TrainingEvent) -> None:
        """Show what has happened."""
        match event:
            case StepEnded():
                self._show_step(event)
            case Driving():
                self._say(f"epoch {event.epoch + 1}: driving the validation routes")
            case EpochEnded():
                parts = [f"{name} {value:.4g}" for name, value in event.row.items()]
                self._say(", ".join(parts))

    def _show_step(self, event: StepEnded) -> None:
        if self._steps is None:
            self._whole = self._bars.add_task("steps of all epochs", total=None)
            self._steps = self._bars.add_task("", total=event.steps)
        old = event.loss if self._loss is None else self._loss
        self._loss = SMOOTHING * old + (1.0 - SMOOTHING) * event.loss
        self._bars.update(
            self._steps,
            total=event.steps,
            completed=event.step,
            description=f"epoch {event.epoch + 1} of {self._epochs}, loss {self._loss:.3f}",
        )
        if self._whole is not None:
            self._bars.update(
                self._whole,
                total=self._epochs * event.steps,
                completed=event.epoch * event.steps + event.step,
            )

    def _say(self, text: str) -> None:
        self._bars.console.print(text, highlight=False, markup=False)


def bars() -> Progress:
    """Return bars to be shown on standard error, as a context."""
    return progress_bars(34, MofNCompleteColumn())


def learn_visibly(course: TrainingRun) -> bool:
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
