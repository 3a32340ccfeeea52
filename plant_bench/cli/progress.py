"""Progress bars on standard error, and the exit on Ctrl-C."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from plant_bench.cli.options import EXIT_INTERRUPTED

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

SPEED_PERIOD = 300  # s over which the speed for the remaining time is averaged


def progress_bars(width: int, count: "ProgressColumn") -> "Progress":
    """Return progress bars; a context manager that shows them.

    Args:
        width: Width of the description, characters.
        count: Column after the bar that shows how much is done.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn(f"{{task.description:<{width}}}"),
        BarColumn(),
        count,
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        speed_estimate_period=SPEED_PERIOD,
    )


@contextmanager
def exit_on_ctrl_c(message: str = "Stopped.") -> Iterator[None]:
    """Exit with a message on standard error if Ctrl-C is pressed.

    Raises:
        typer.Exit: Ctrl-C was pressed.
    """
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(message, err=True)
        raise typer.Exit(EXIT_INTERRUPTED) from None
