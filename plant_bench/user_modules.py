"""Loads users' planners and learners by module or file; finds their files for checksums."""

import hashlib
import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from plant_bench.errors import InputError, did_you_mean
from plant_bench.renamed import renamed_import
from plant_bench.source_code import source_of
from plant_bench.user_code import loading_error

_PACKAGE = Path(__file__).resolve().parent
_INSTALLED = {"site-packages", "dist-packages"}


def _root(file: Path) -> Path:
    """Return the folder of a file, or of the whole package it is in."""
    root = file.resolve().parent
    while (root / "__init__.py").is_file() and (root.parent / "__init__.py").is_file():
        root = root.parent
    return root


def package_files(file: Path) -> set[Path]:
    """Return all modules of a file's package; only the file itself if it is in no package."""
    root = _root(file)
    return set(root.rglob("*.py")) if (root / "__init__.py").is_file() else {file.resolve()}


def own_files(file: Path) -> set[Path]:
    """Return a file and all files that it imports from its own folder or package.

    Imports inside functions count. Imports by computed names and files that are read do not:
    planners list these in `files`. plant-bench itself, and packages installed below that folder,
    are excluded.
    """
    root = _root(file)
    base = root.parent if (root / "__init__.py").is_file() else root
    found: set[Path] = set()
    pending = [file.resolve()]
    while pending:
        path = pending.pop()
        if path in found or not _is_own(path, root):
            continue
        found.add(path)
        if path.suffix == ".py":
            for name in source_of(path).modules:
                pending += _files_of(name, path, base)
    return found | {file.resolve()}


def _files_of(name: str, importer: Path, base: Path) -> list[Path]:
    """Return the files below a folder that an import loads."""
    start = base
    if name.startswith("."):
        level = len(name) - len(name.lstrip("."))
        start = importer.parents[level - 1]
    parts = [part for part in name.strip(".").split(".") if part]
    paths = [start.joinpath(*parts[:count]) for count in range(len(parts) + 1)]
    candidates = [path / "__init__.py" for path in paths]
    candidates += [path.with_suffix(".py") for path in paths[1:]]
    return [path.resolve() for path in candidates if path.is_file()]


def _is_own(path: Path, root: Path) -> bool:
    if not path.is_relative_to(root) or path.is_relative_to(_PACKAGE):
        return False
    return _INSTALLED.isdisjoint(path.relative_to(root.parent).parts)


def load_named(module: str, name: str, who: str) -> Any:
    """Return a class or factory function from a module.

    Args:
        module: The module's dotted name, or the path of a Python file.
        name: The name in the module.
        who: Description for error messages, such as "agent 'mine.py:Mine'".

    Raises:
        InputError: There is no such module or name, or the module raised an exception.
    """
    found = load_module(module, who)
    value = getattr(found, name, None)
    if value is None:
        names = [known for known, item in vars(found).items() if isinstance(item, type)]
        hint = did_you_mean(name, names, cutoff=0.5, quote="'")
        message = f"There is no '{name}' in {module}.{hint}"
        raise InputError(message)
    return value


def load_module(module: str, who: str) -> ModuleType:
    """Return a module by its dotted name or file path; see `load_named`.

    Raises:
        InputError: There is no such module, or it raised an exception.
    """
    try:
        if module.endswith(".py"):
            return _from_file(Path(module))
        _find_modules_in(Path.cwd())
        return importlib.import_module(module)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        hint = renamed_import(error)
        raise loading_error(f"The {who} cannot be loaded", error, hint) from error


def forget_file(module: str) -> None:
    """Drop a module that is a file from the cache, so that an edited file is loaded again.

    Only for interactive processes. A worker keeps the code that it loaded first: the run's key
    identifies that code.
    """
    if module.endswith(".py"):
        sys.modules.pop(_name_of(Path(module).expanduser().resolve()), None)


def _name_of(path: Path) -> str:
    return f"plant_bench_agent_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"


def _find_modules_in(folder: Path) -> None:
    """Add a folder to the import path, as Python does for a script in it."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


def _from_file(path: Path) -> ModuleType:
    """Load a file once per process."""
    path = path.expanduser().resolve()
    _find_modules_in(path.parent)
    if not path.is_file():
        message = f"There is no file {path}."
        raise InputError(message)
    name = _name_of(path)
    if name in sys.modules:
        return sys.modules[name]
    found = importlib.util.spec_from_file_location(name, path)
    if found is None or found.loader is None:
        message = f"{path} is not a Python file."
        raise InputError(message)
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module
    try:
        found.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module
