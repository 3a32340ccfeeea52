"""Progress bars of `plant-bench train` on standard error."""

import typer
from rich.progress import MofNCompleteColumn, Progress, TaskID

from plant_bench.cli.progress import progress_bars
from plant_bench.training.batches import Split
from plant_bench.training.events import Driving, EpochEnded, StepEnded, TrainingEvent
from plant_bench.training.history import NO_TENSORBOARD, has_tensorboard
from plant_bench.training.training_run import Listeners, TrainingRun, run_training

SMOOTHING = 0.98  # exponential smoothing of the displayed loss


class EpisodesProgress:
    """A bar for the preprocessing of episodes, shown with the first one; mutable.

    Args:
        bars: The progress bars on display.
        description: Text of the bar.
    """

    def __init__(self, bars: Progress, description: str) -> None:
        self._bars, self._description = bars, description
        self._task: TaskID | None = None

    def __call__(self, done: int, total: int) -> None:
        """Show the number of finished episodes."""
        if self._task is None:
            self._task = self._bars.add_task(self._description, total=total)
        self._bars.update(self._task, completed=done)


class TrainingProgress:
    """Bars that follow the events of a training; mutable.

    Args:
        bars: The progress bars on display.
        epochs: Number of epochs.
    """

    def __init__(self, bars: Progress, epochs: int) -> None:
        self._bars = bars
        self._epochs = epochs
        self._loss: float | None = None
        self._total: TaskID | None = None
        self._steps: TaskID | None = None

    def __call__(self, event: TrainingEvent) -> None:
        """Update the bars with an event."""
        match event:
            case StepEnded():
                self._show_step(event)
            case Driving():
                self._print(f"epoch {event.epoch + 1}: driving the validation routes")
            case EpochEnded():
                parts = [f"{name} {value:.4g}" for name, value in event.row.items()]
                self._print(", ".join(parts))

    def _show_step(self, event: StepEnded) -> None:
        if self._steps is None:
            self._total = self._bars.add_task("steps of all epochs", total=None)
            self._steps = self._bars.add_task("", total=event.steps)
        old = event.loss if self._loss is None else self._loss
        self._loss = SMOOTHING * old + (1.0 - SMOOTHING) * event.loss
        self._bars.update(
            self._steps,
            total=event.steps,
            completed=event.step,
            description=f"epoch {event.epoch + 1} of {self._epochs}, loss {self._loss:.3f}",
        )
        if self._total is not None:
            self._bars.update(
                self._total,
                total=self._epochs * event.steps,
                completed=event.epoch * event.steps + event.step,
            )

    def _print(self, text: str) -> None:
        self._bars.console.print(text, highlight=False, markup=False)


def bars() -> Progress:
    """Return the progress bars; a context manager that shows them on standard error."""
    return progress_bars(34, MofNCompleteColumn())


def train_with_progress(run: TrainingRun) -> bool:
    """Train with progress bars; return False if Ctrl-C ended the training.

    Raises:
        InputError: Data or a folder cannot be used, or the folder belongs to another training.
    """
    with bars() as shown:
        finished = run_training(
            run,
            Listeners(
                on_frames=EpisodesProgress(shown, "episodes converted to frames"),
                on_encodings=EpisodesProgress(shown, "episodes encoded"),
                on_split=print_split,
                on_event=TrainingProgress(shown, run.settings.epochs),
            ),
        )
    if not finished:
        typer.echo("Stopped. Run the same command again to continue.", err=True)
    else:
        typer.echo(f"Model: {run.out}")
    return finished


def print_split(split: Split) -> None:
    """Print the sizes of the training and the validation set."""
    typer.echo(
        f"{len(split.training)} training samples, {len(split.validation)} validation samples "
        f"(from {len(split.held_out)} held-out routes).",
        err=True,
    )
    if not has_tensorboard():
        typer.echo(NO_TENSORBOARD, err=True)
