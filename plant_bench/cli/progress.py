"""What long commands show on standard error, and how Ctrl-C ends them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from plant_bench.cli.options import EXIT_INTERRUPTED

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

STEADINESS = 300  # s over which the speed is taken for the time that remains


def progress_bars(width: int, count: "ProgressColumn") -> "Progress":
    """Return bars to be shown, as a context.

    Args:
        width: Of the description, characters.
        count: What is shown behind the bar: how much is done.
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
        speed_estimate_period=STEADINESS,
    )


@contextmanager
def ending_at_ctrl_c(message: str = "Stopped.") -> Iterator[None]:
    """Say on standard error that Ctrl-C has ended the work, and leave.

    Raises:
        typer.Exit: Ctrl-C was pressed.
    """
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(message, err=True)
        raise typer.Exit(EXIT_INTERRUPTED) from None
