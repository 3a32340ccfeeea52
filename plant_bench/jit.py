"""Compiles loops over small arrays with numba, ahead of use; a numpy call would take longer.

Compiled functions are cached on disk, beside the source or in the user's cache, in a folder named
after a hash of their file, of this file, and of numba's version. Changes of other files would go
unnoticed: a compiled function must therefore use nothing that its file imports from plant-bench;
such values are passed as arguments (a test checks this).

Sums are computed in the order of the loops, and no operations are fused. Actors' values are
float32, and so are sums and products of these alone. An index out of range raises `IndexError`.
"""

import functools
import hashlib
import inspect
import logging
import multiprocessing
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numba
from numba import njit, types
from numba.core import config

F64, F32, INT64 = types.float64, types.float32, types.int64
BOOL = types.boolean

_settings: Any = config  # includes NUMBA_* variables; its attributes are created at import


def _read_only(item: types.Type, dimensions: int) -> types.Array:
    """Return the type of a read-only array with any memory layout."""
    return types.Array(item, dimensions, "A", readonly=True)


F64_1D, F64_2D, F64_3D = (_read_only(F64, dimensions) for dimensions in (1, 2, 3))
F32_1D, F32_2D = (_read_only(F32, dimensions) for dimensions in (1, 2))
NEW_F64_1D, NEW_F64_2D = types.Array(F64, 1, "C"), types.Array(F64, 2, "C")
NEW_F32_2D = types.Array(F32, 2, "C")
INT64_1D = _read_only(INT64, 1)
BOOL_1D = _read_only(BOOL, 1)


def compiled(*arguments: types.Type) -> Callable[[Callable], Callable]:
    """Return a decorator that compiles a function at its definition.

    Args:
        arguments: The types of the function's arguments.
    """

    def made(function: Callable) -> Callable:
        plain = inspect.unwrap(function)  # jaxtyping's wrappers in tests cannot be compiled
        folder = _folder(inspect.getfile(plain))
        found = None
        if folder is not None:
            try:
                with _cached_in(folder):
                    found = _compile(plain, arguments, keep=True)
            except Exception:  # noqa: BLE001  a broken or full folder; other errors recur below
                shutil.rmtree(folder, ignore_errors=True)
        if found is None:
            found = _compile(plain, arguments, keep=False)
        if not found.stats.cache_hits:
            _log_once()
        return found

    return made


def _compile(function: Callable, arguments: tuple[types.Type, ...], *, keep: bool) -> Any:
    return njit(arguments, cache=keep, error_model="numpy", boundscheck=True)(function)


@contextmanager
def _cached_in(folder: Path) -> Iterator[None]:
    """Set numba's cache folder."""
    before, _settings.CACHE_DIR = _settings.CACHE_DIR, str(folder)
    try:
        yield
    finally:
        _settings.CACHE_DIR = before


@functools.cache
def _folder(source: str) -> Path | None:
    """Return the cache folder of a file's functions; None if no place is writable."""
    path = Path(source)
    digest = hashlib.sha256(numba.__version__.encode())
    for part in (path, Path(__file__)):
        digest.update(part.read_bytes())
    name = f"{path.stem}-{digest.hexdigest()[:16]}"
    beside = path.parent / "__pycache__" / "compiled"
    for base in (beside, *_elsewhere()):
        folder = base / name
        with suppress(OSError):
            if base == beside and not folder.is_dir():
                _sweep(base, path.stem)
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
    return None


def _elsewhere() -> Iterator[Path]:
    """Yield cache folders for an installation that is not writable."""
    if _settings.CACHE_DIR:
        yield Path(_settings.CACHE_DIR)
    with suppress(RuntimeError):  # no home directory
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "plant-bench"


def _sweep(base: Path, stem: str) -> None:
    """Remove the cache of a file's earlier versions."""
    for old in base.glob(f"{stem}-" + "[0-9a-f]" * 16):
        shutil.rmtree(old, ignore_errors=True)


@functools.cache
def _log_once() -> None:
    """Log once, on a terminal, why the start takes longer."""
    if sys.stderr.isatty() and multiprocessing.parent_process() is None:
        message = "Compiling planners for this processor: takes some seconds, the first time only."
        logging.getLogger(__name__).warning(message)
