"""Ctrl-C ends a command with a word and the exit code of a shell, never with a traceback."""

from collections.abc import Iterator
from contextlib import contextmanager

import typer

from plant_bench.cli.options import EXIT_INTERRUPTED


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
