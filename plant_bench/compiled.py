"""Loops over small arrays as machine code (numba): a call of numpy costs more than they do.

Nothing is compiled, and numba not even loaded, before the first call or `compile_all`: a command
that asks a planner for its name alone need not wait for it.

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
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any


@dataclass(frozen=True)
class Argument:
    """The type of an argument.

    Attributes:
        item: Of a number, or of an array's elements: numba's name.
        axes: Of an array; 0 for a number.
        new: An array that the caller has made for it, to be written to; others are only read,
            however they lie in memory.
    """

    item: str
    axes: int = 0
    new: bool = False


REAL, SINGLE, WHOLE, FLAG = map(Argument, ("float64", "float32", "int64", "boolean"))
REALS, REALS_2D, REALS_3D = (Argument("float64", axes) for axes in (1, 2, 3))
SINGLES, SINGLES_2D = (Argument("float32", axes) for axes in (1, 2))
NEW_REALS, NEW_REALS_2D = (Argument("float64", axes, new=True) for axes in (1, 2))
NEW_SINGLES_2D = Argument("float32", 2, new=True)
WHOLES, FLAGS = Argument("int64", 1), Argument("boolean", 1)


class Compiled:
    """A function that is machine code from its first call on.

    Attributes:
        plain: The function as it is written.

    Args:
        function: The same.
        arguments: The types, one an argument.
    """

    def __init__(self, function: Callable, arguments: tuple[Argument, ...]) -> None:
        # Tests check what is imported, and numba cannot compile their checks.
        self.plain: Any = inspect.unwrap(function)
        self._arguments = arguments
        self._run: Callable = self._first
        _waiting.append(self)
        functools.update_wrapper(self, self.plain)

    def __call__(self, *given: Any) -> Any:
        """Return what the function returns."""
        return self._run(*given)

    @functools.cached_property
    def machine(self) -> Any:
        """What numba has made of it."""
        folder, function = self._folder, self._calling_machines()
        found = None
        if folder is not None:
            try:
                with _keeping_in(folder):
                    found = _compile(function, self._arguments, keep=True)
            except Exception:  # noqa: BLE001  a broken or full folder; what else it is, is raised below
                shutil.rmtree(folder, ignore_errors=True)
        if found is None:
            found = _compile(function, self._arguments, keep=False)
        if not found.stats.cache_hits:
            _tell(kept=folder is not None)
        self._run = found
        with suppress(ValueError):
            _waiting.remove(self)
        return found

    @property
    def is_kept(self) -> bool:
        """Whether it was compiled before, and lies on the disk; False if that is broken."""
        name = f"*.{self.plain.__name__}-*.nbi"
        return self._folder is not None and any(self._folder.glob(name))

    @property
    def _folder(self) -> Path | None:
        return _folder(inspect.getfile(self.plain))

    def _first(self, *given: Any) -> Any:
        return self.machine(*given)

    def _calling_machines(self) -> FunctionType:
        """Return the function with the compiled ones that it calls as numba knows them."""
        plain = self.plain
        names = dict(plain.__globals__)
        for name in _names(plain.__code__):
            called = names.get(name)
            if isinstance(called, Compiled) and called is not self:
                names[name] = called.machine
        made = FunctionType(
            plain.__code__, names, plain.__name__, plain.__defaults__, plain.__closure__
        )
        functools.update_wrapper(made, plain)
        return made


_waiting: list[Compiled] = []


def compiled(*arguments: Argument) -> Callable[[Callable], Compiled]:
    """Compile a function, when it is first called, for arguments of some types.

    Args:
        arguments: The types, one an argument.
    """

    def made(function: Callable) -> Compiled:
        return Compiled(function, arguments)

    return made


def compile_all() -> None:
    """Compile all functions of the modules that are loaded, or read what is kept of them."""
    for function in _waiting.copy():
        _ = function.machine


def tell_what_others_compile() -> None:
    """Say, before other processes compile what is loaded here, why they take longer to start."""
    missing = [function for function in _waiting if not function.is_kept]
    if missing:
        _tell(kept=missing[0]._folder is not None)


def _names(code: CodeType) -> set[str]:
    """Return the names that a function and those within it use."""
    inner = (item for item in code.co_consts if isinstance(item, CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _compile(function: Callable, arguments: tuple[Argument, ...], *, keep: bool) -> Any:
    from numba import njit

    given = tuple(map(_type, arguments))
    return njit(given, cache=keep, error_model="numpy", boundscheck=True)(function)


def _type(argument: Argument) -> Any:
    from numba import types

    item = getattr(types, argument.item)
    if not argument.axes:
        return item
    if argument.new:
        return types.Array(item, argument.axes, "C")
    return types.Array(item, argument.axes, "A", readonly=True)


@contextmanager
def _keeping_in(folder: Path) -> Iterator[None]:
    """Let numba keep what it compiles in a folder."""
    from numba.core import config

    settings: dict[str, Any] = config.__dict__
    before, settings["CACHE_DIR"] = settings["CACHE_DIR"], str(folder)
    try:
        yield
    finally:
        settings["CACHE_DIR"] = before


@functools.cache
def _folder(source: str) -> Path | None:
    """Return where the functions of a file are kept; None where nothing can be written."""
    path = Path(source)
    digest = hashlib.sha256(version("numba").encode())
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
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given)
    with suppress(RuntimeError):  # there is no home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "plant-bench"


def _sweep(base: Path, stem: str) -> None:
    """Remove what was kept of a file's earlier contents."""
    for old in base.glob(f"{stem}-" + "[0-9a-f]" * 16):
        shutil.rmtree(old, ignore_errors=True)


@functools.cache
def _tell(*, kept: bool) -> None:
    """Say, once and to a person, why the start takes longer."""
    if sys.stderr.isatty() and multiprocessing.parent_process() is None:
        often = ", the first time only" if kept else ": there is no place to keep them"
        message = f"Compiling planners' loops for this processor: some seconds{often}."
        logging.getLogger(__name__).warning(message)
