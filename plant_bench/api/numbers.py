"""Ranges of the numbers that the functions and commands share."""

import math
from numbers import Integral, Real

from plant_bench.errors import InputError

HIGHEST_SEED = 2**31 - 1
MOST_FRAMES = 228_000_000  # a thousand of PlanT's units
MOST_PROCESSES = 10_000
MOST_REPETITIONS = 10_000  # as in `plant_bench.scoring.results`, which is slow to import
UNITS_RANGE = (1e-5, 1000.0)


def check_whole_number(name: str, value: int, low: int, high: int) -> None:
    """Check an argument that is a whole number from `low` to `high`.

    Args:
        name: Name of the argument, for the message.
        value: The argument.
        low: Minimum.
        high: Maximum.

    Raises:
        InputError: It is not such a number.
    """
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not low <= value <= high:
        message = f"{name}: expected a whole number from {low} to {high}, got {value!r}."
        raise InputError(message)


def check_number(name: str, value: float, low: float, high: float) -> None:
    """Check an argument that is a finite number from `low` to `high`.

    Args:
        name: Name of the argument, for the message.
        value: The argument.
        low: Minimum.
        high: Maximum.

    Raises:
        InputError: It is not such a number.
    """
    real = isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    if not real or not low <= value <= high:
        message = f"{name}: expected a number from {low:g} to {high:g}, got {value!r}."
        raise InputError(message)


def check_episodes(repetitions: int, seed: int, workers: int | None) -> None:
    """Check the numbers of a run.

    Raises:
        InputError: One is not a whole number within its range.
    """
    check_whole_number("repetitions", repetitions, 1, MOST_REPETITIONS)
    check_whole_number("seed", seed, 0, HIGHEST_SEED)
    if workers is not None:
        check_whole_number("workers", workers, 1, MOST_PROCESSES)
