"""The bars that long commands show on standard error."""

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

STEADINESS = 300  # s over which the speed is taken for the time that remains


def progress_bars(width: int, count: ProgressColumn) -> Progress:
    """Return bars to be shown, as a context.

    Args:
        width: Of the description, characters.
        count: What is shown behind the bar: how much is done.
    """
    return Progress(
        TextColumn(f"{{task.description:<{width}}}"),
        BarColumn(),
        count,
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        speed_estimate_period=STEADINESS,
    )
