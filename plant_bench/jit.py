"""Loops over small arrays as machine code (numba): a call of numpy costs more than they do.

A compiled function is kept on the disk, beside its source or in the user's cache, in a folder that
is named by the content of its own file, of this one, and numba's version. A change of another file
would not be noticed: it therefore uses nothing that its file imports from plant-bench, but is given
such numbers (a test holds to that).

Sums are made in the order of the loops, and no operations are fused. Actors' numbers are float32,
and so are sums and products of these alone. An index beyond an array's end raises `IndexError`.
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

_settings: Any = config  # also what NUMBA_* sets; its names are made when it is imported


def _read_only(item: types.Type, dimensions: int) -> types.Array:
    """Return the type of an array that is only read, however it lies in memory."""
    return types.Array(item, dimensions, "A", readonly=True)


F64_1D, F64_2D, F64_3D = (_read_only(F64, dimensions) for dimensions in (1, 2, 3))
F32_1D, F32_2D = (_read_only(F32, dimensions) for dimensions in (1, 2))
NEW_F64_1D, NEW_F64_2D = types.Array(F64, 1, "C"), types.Array(F64, 2, "C")
NEW_F32_2D = types.Array(F32, 2, "C")
INT64_1D = _read_only(INT64, 1)
BOOL_1D = _read_only(BOOL, 1)


def compiled(*arguments: types.Type) -> Callable[[Callable], Callable]:
    """Compile a function, when it is defined, for arguments of some types.

    Args:
        arguments: The types, one an argument.
    """

    def made(function: Callable) -> Callable:
        plain = inspect.unwrap(function)  # tests check what is imported, which numba cannot compile
        folder = _folder(inspect.getfile(plain))
        found = None
        if folder is not None:
            try:
                with _keeping_in(folder):
                    found = _compile(plain, arguments, keep=True)
            except Exception:  # noqa: BLE001  a broken or full folder; what else it is, is raised below
                shutil.rmtree(folder, ignore_errors=True)
        if found is None:
            found = _compile(plain, arguments, keep=False)
        if not found.stats.cache_hits:
            _tell()
        return found

    return made


def _compile(function: Callable, arguments: tuple[types.Type, ...], *, keep: bool) -> Any:
    return njit(arguments, cache=keep, error_model="numpy", boundscheck=True)(function)


@contextmanager
def _keeping_in(folder: Path) -> Iterator[None]:
    """Let numba keep what it compiles in a folder."""
    before, _settings.CACHE_DIR = _settings.CACHE_DIR, str(folder)
    try:
        yield
    finally:
        _settings.CACHE_DIR = before


@functools.cache
def _folder(source: str) -> Path | None:
    """Return where the functions of a file are kept; None where nothing can be written."""
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
    """Where an installation that must not be written to keeps what is compiled."""
    if _settings.CACHE_DIR:
        yield Path(_settings.CACHE_DIR)
    with suppress(RuntimeError):  # there is no home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "plant-bench"


def _sweep(base: Path, stem: str) -> None:
    """Remove what was kept of a file's earlier contents."""
    for old in base.glob(f"{stem}-" + "[0-9a-f]" * 16):
        shutil.rmtree(old, ignore_errors=True)


@functools.cache
def _tell() -> None:
    """Say, once and to a person, why the start takes longer."""
    if sys.stderr.isatty() and multiprocessing.parent_process() is None:
        message = "Compiling planners' loops for this processor: some seconds, the first time only."
        logging.getLogger(__name__).warning(message)
