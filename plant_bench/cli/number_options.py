"""Options that take a number: finite, and within a range."""

import math
from collections.abc import Callable
from typing import Any

import typer

Number = int | float

LONGEST_TIME = 1e6  # s


def number_option(text: str, low: Number, high: Number, *names: str) -> Any:
    """Return an option that takes a finite number from `low` to `high`.

    Args:
        text: Help text.
        low: Minimum.
        high: Maximum.
        names: Names of the option, if they are not that of the parameter.
    """
    return typer.Option(*names, help=text, min=low, max=high, callback=number_check(low, high))


def number_check(low: Number | None = None, high: Number | None = None) -> Callable[[Any], Any]:
    """Return a callback that refuses numbers that are not finite or not within a range.

    It is needed beside an option's `min` and `max`, because NaN passes comparisons with them in
    some versions of typer, and because they do not apply to the parts of a tuple.

    Args:
        low: Minimum; None for no minimum.
        high: Maximum; None for no maximum.

    Returns:
        The callback: it returns a valid value, and raises `typer.BadParameter` for any other.
    """

    def check(value: Any) -> Any:
        for part in value if isinstance(value, list | tuple) else [value]:
            if not isinstance(part, int | float):
                continue  # an option that was not passed
            if not math.isfinite(part):
                raise typer.BadParameter(f"expected a finite number{_range(low, high)}.")
            if (low is not None and part < low) or (high is not None and part > high):
                raise typer.BadParameter(f"expected a number{_range(low, high)}, got {part}.")
        return value

    return check


def _range(low: Number | None, high: Number | None) -> str:
    """Return the words for a range.

    >>> _range(0.0, 1.0), _range(0.0, None), _range(None, None)
    (' from 0 to 1', ' of at least 0', '')
    """
    if low is not None and high is not None:
        return f" from {low:g} to {high:g}"
    if low is not None:
        return f" of at least {low:g}"
    return f" of at most {high:g}" if high is not None else ""
