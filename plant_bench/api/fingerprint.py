"""Hashes a planner that is defined in a notebook, where no file holds its code.

The hash covers the code of its class, bases and functions, all globals that they use, and the
values of an object. For imports from a file it covers the file or its whole package; for installed
packages only the names. Comments, line numbers and cell names are excluded, so the same cells give
the same fingerprint in another session.

The pickle is not hashed instead, because equal sets are pickled differently in each process.
"""

import dis
import hashlib
import sys
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from types import (
    BuiltinFunctionType,
    CellType,
    CodeType,
    FunctionType,
    MappingProxyType,
    MethodType,
    ModuleType,
)
from typing import Any

import cloudpickle
import numpy as np

from plant_bench.agents.loading.checksum import HARMLESS
from plant_bench.source_code import file_hash, import_closure, module_file, module_name
from plant_bench.user_modules import own_files, package_files

_ATOMS = (type(None), bool, int, float, complex, str, bytes, type(...))
_INSTALLED = {"site-packages", "dist-packages"}
_GLOBAL_OPCODES = {"LOAD_GLOBAL", "LOAD_NAME", "STORE_GLOBAL", "DELETE_GLOBAL"}
_IGNORED_ATTRIBUTES = frozenset(
    {"__module__", "__dict__", "__weakref__", "__doc__", "__annotations__", "_abc_impl"}
    | {"__firstlineno__", "__static_attributes__", "__annotate_func__", "__annotations_cache__"}
)


def fingerprint(value: object) -> str:
    """Return the hash of a class, a function or an object."""
    walk = _Walk()
    walk.add(value)
    return walk.digest.hexdigest()


class _Walk:
    """Hashes a value and all its parts recursively, each once; mutable.

    Attributes:
        digest: Hash of the values visited so far.
    """

    def __init__(self, visited: dict[int | str, int] | None = None) -> None:
        self.digest = hashlib.sha256()
        self._visited: dict[int | str, int] = {} if visited is None else visited
        self._kept_alive: list[object] = []  # so that no two values share an id

    def add(self, value: Any) -> None:
        """Hash a value and all its parts."""
        if isinstance(value, _ATOMS):
            self._say(type(value).__name__, repr(value))
        elif isinstance(value, np.ndarray | np.generic) and value.dtype != object:
            self._say("array", str(value.dtype), str(value.shape), value.tobytes().hex())
        elif isinstance(value, tuple) and type(value) is tuple:
            self._add_all("tuple", value)
        elif type(value) in (set, frozenset):
            members: Any = value
            self._say("set", *sorted(map(self._separate_digest, members)))
        elif not self._was_visited(value):
            self._add_new(value)

    def _add_new(self, value: Any) -> None:
        if _is_tensor(value):
            plain = value.detach().cpu().clone().reshape(-1)
            plain = plain.view(sys.modules["torch"].uint8)
            self._add_all("tensor", (str(value.dtype), tuple(value.shape), plain.numpy()))
        elif isinstance(value, Enum):
            self._add_all("enum", (type(value), value.name))
        elif isinstance(value, ModuleType):
            self._add_module(value.__name__)
        elif isinstance(value, type | FunctionType | BuiltinFunctionType) and _is_imported(value):
            self._say("imported", value.__qualname__)
            self._add_module(value.__module__)
        elif isinstance(value, type):
            self._add_class(value)
        elif isinstance(value, CodeType):
            self._add_code(value)
        elif isinstance(value, FunctionType):
            self._add_function(value)
        elif type(value) is list:
            self._add_all("list", value)
        elif isinstance(value, MappingProxyType) or type(value) is dict:
            self._add_all("dict", [part for item in value.items() for part in item])
        else:
            self._add_object(value)

    def _add_class(self, value: type) -> None:
        self._add_all("class", (value.__qualname__, type(value), *value.__bases__))
        for name, part in sorted(vars(value).items()):
            if name not in _IGNORED_ATTRIBUTES:
                self._say(name)
                self.add(part)

    def _add_function(self, value: FunctionType) -> None:
        self._add_all(
            "function",
            (value.__qualname__, value.__code__, value.__defaults__, value.__kwdefaults__),
        )
        self._add_all("closure", [_content(cell) for cell in value.__closure__ or ()])
        for name in sorted(_names_in(value.__code__)):
            if name in value.__globals__:
                self._say(name)
                self.add(value.__globals__[name])

    def _add_code(self, value: CodeType) -> None:
        numbers = (value.co_argcount, value.co_posonlyargcount, value.co_kwonlyargcount)
        names = (value.co_names, value.co_varnames, value.co_freevars, value.co_cellvars)
        tables = (value.co_code, value.co_exceptiontable, value.co_flags)
        self._add_all("code", (*numbers, *names, *tables, value.co_consts))

    def _add_object(self, value: Any) -> None:
        """Hash an object by the parts from which pickle would rebuild it."""
        if isinstance(value, property):
            self._add_all("property", (value.fget, value.fset, value.fdel))
        elif isinstance(value, staticmethod | classmethod):
            self._add_all(type(value).__name__, (value.__func__,))
        elif isinstance(value, MethodType):
            self._add_all("method", (value.__self__, value.__func__))
        elif isinstance(getattr(value, "py_func", None), FunctionType):  # compiled by numba
            self._add_all("compiled", (value.py_func,))
        else:
            self._add_all("object", _parts_of(value))

    def _add_module(self, name: str) -> None:
        """Hash an imported module: its name, and its files if they belong to the planner."""
        self._say("module", name)
        file = getattr(sys.modules.get(name), "__file__", None)
        for path in sorted(_own_files(name, Path(file).resolve() if file else None)):
            if not self._was_visited(str(path)):
                self._say(path.name, _content_hash(path))

    def _add_all(self, what: str, values: Any) -> None:
        self._say(what, str(len(values)))
        for value in values:
            self.add(value)

    def _separate_digest(self, value: object) -> str:
        walk = _Walk(dict(self._visited))
        walk.add(value)
        return walk.digest.hexdigest()

    def _was_visited(self, value: object) -> bool:
        """Return whether a value was hashed before; if so, hash a reference to it."""
        key = value if isinstance(value, str) else id(value)
        if key in self._visited:
            self._say("met", str(self._visited[key]))
            return True
        self._visited[key] = len(self._visited)
        self._kept_alive.append(value)
        return False

    def _say(self, *words: str) -> None:
        for word in words:
            content = word.encode("utf-8", "surrogatepass")
            self.digest.update(len(content).to_bytes(8, "big"))
            self.digest.update(content)


def _is_tensor(value: object) -> bool:
    """Return whether a value is a torch tensor, whose pickle depends on its memory address."""
    torch: Any = sys.modules.get("torch")
    return torch is not None and isinstance(value, torch.Tensor)


def _is_imported(value: Any) -> bool:
    """Return whether a class or function can be imported by name; false for notebook code."""
    if value.__module__ == "builtins":  # some built-ins are not attributes of the module
        return True
    if value.__module__ in (None, "__main__"):
        return False
    target: object = sys.modules.get(value.__module__)
    for name in value.__qualname__.split("."):
        target = getattr(target, name, None)
    return target is value


def _names_in(code: CodeType) -> set[str]:
    """Return the global names that code uses, including its nested functions."""
    names = {item.argval for item in dis.get_instructions(code) if item.opname in _GLOBAL_OPCODES}
    inner = [part for part in code.co_consts if isinstance(part, CodeType)]
    return names.union(*map(_names_in, inner))


def _content(cell: CellType) -> object:
    try:
        return cell.cell_contents
    except ValueError:  # the cell is empty
        return None


def _parts_of(value: object) -> tuple[object, ...]:
    """Return the parts from which pickle would rebuild an object."""
    try:
        reduced = value.__reduce_ex__(4)
    except TypeError:
        return (type(value), getattr(value, "__qualname__", ""), _pickled(value))
    if isinstance(reduced, str):
        return (type(value), reduced)
    return tuple(list(part) if isinstance(part, Iterator) else part for part in reduced)


def _pickled(value: object) -> bytes:
    """Return the cloudpickle of a value that pickle cannot handle; empty if that fails, too."""
    try:
        return cloudpickle.dumps(value)
    except TypeError:  # an object of the interpreter, such as a generator
        return b""


def _own_files(name: str, file: Path | None) -> set[Path]:
    """Return a module's files that belong to the planner, including files it loads beside it."""
    if file is None or name.partition(".")[0] in sys.stdlib_module_names:
        return set()
    if not _INSTALLED.isdisjoint(file.parts):
        return set()
    if module_name(file) is not None:
        return {module_file(other) for other in import_closure(name, without=HARMLESS)}
    return package_files(file) | own_files(file)


def _content_hash(path: Path) -> str:
    try:
        return file_hash(path)
    except OSError:  # the file was removed after loading
        return ""
