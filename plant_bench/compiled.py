"""Loops over small arrays as machine code (numba): a call of numpy costs more than they do.

A compiled function is kept on the disk, beside its source or in the user's cache, and made anew
when its own file changes. A change of another file would not be noticed: it therefore uses no name
that its file imports from plant-bench, but is given such numbers (a test holds to that).

Sums are made in the order of the loops, and no operations are fused. Actors' numbers are float32,
and so are sums and products of these alone.
"""

import functools
import inspect
import logging
import multiprocessing
import sys
from collections.abc import Callable

from numba import njit, types

REAL, SINGLE, WHOLE = types.float64, types.float32, types.int64
FLAG = types.boolean


def _read_only(item: types.Type, dimensions: int) -> types.Array:
    """Return the type of an array that is only read, however it lies in memory."""
    return types.Array(item, dimensions, "A", readonly=True)


REALS, REALS_2D, REALS_3D = (_read_only(REAL, dimensions) for dimensions in (1, 2, 3))
SINGLES, SINGLES_2D = (_read_only(SINGLE, dimensions) for dimensions in (1, 2))
NEW_REALS, NEW_REALS_2D = types.Array(REAL, 1, "C"), types.Array(REAL, 2, "C")
NEW_SINGLES_2D = types.Array(SINGLE, 2, "C")
WHOLES = _read_only(WHOLE, 1)
BYTES = _read_only(types.uint8, 1)
FLAGS = _read_only(FLAG, 1)


def compiled(*arguments: types.Type) -> Callable[[Callable], Callable]:
    """Compile a function, when it is defined, for arguments of some types.

    Args:
        arguments: The types, one an argument.
    """

    def made(function: Callable) -> Callable:
        plain = inspect.unwrap(function)  # tests check what is imported, which numba cannot compile
        try:
            function = njit(arguments, cache=True, error_model="numpy")(plain)
        except RuntimeError:  # there is no folder in which it could be kept
            function = njit(arguments, error_model="numpy")(plain)
        if not function.stats.cache_hits:
            _tell()
        return function

    return made


@functools.cache
def _tell() -> None:
    """Say, once and to a person, why the start takes longer."""
    if sys.stderr.isatty() and multiprocessing.parent_process() is None:
        message = "Compiling planners' loops for this processor: some seconds, the first time only."
        logging.getLogger(__name__).warning(message)
