"""Which files belong to a module that is not one of ours: what checksums of planners cover."""

import sys
from pathlib import Path

_OURS = Path(__file__).resolve().parent
_INSTALLED = {"site-packages", "dist-packages"}


def _root(file: Path) -> Path:
    """Return the folder of a file, or of the whole package it is in."""
    root = file.resolve().parent
    while (root / "__init__.py").is_file() and (root.parent / "__init__.py").is_file():
        root = root.parent
    return root


def package_files(file: Path) -> set[Path]:
    """Return all modules of the package that a file is in; the file alone where there is none."""
    root = _root(file)
    return set(root.rglob("*.py")) if (root / "__init__.py").is_file() else {file.resolve()}


def files_loaded_beside(file: Path) -> set[Path]:
    """Return the files of all modules loaded from a file's folder, or from its whole package.

    plant-bench itself and installed packages, which may lie below that folder, are no part of it:
    which of their modules are loaded depends on the command.
    """
    root = _root(file)
    loaded = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    # A few modules (torch._classes) give a bare name that is no file's.
    files = {Path(name).resolve() for name in loaded if name and Path(name).is_absolute()}
    return {file.resolve()} | {path for path in files if _is_own(path, root)}


def _is_own(path: Path, root: Path) -> bool:
    if not path.is_relative_to(root) or path.is_relative_to(_OURS):
        return False
    return _INSTALLED.isdisjoint(path.relative_to(root.parent).parts)
