"""Which code decides a cached number: the modules that a module imports, and a hash of them."""

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Iterable
from pathlib import Path


def import_closure(*modules: str) -> frozenset[str]:
    """Return some modules, and all of their own package that they import, lazily or not."""
    found: set[str] = set()
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name in found or _file(name) is None:
            continue
        found.add(name)
        waiting += [other for other in _imported(name) if _root(other) == _root(name)]
    return frozenset(found)


def code_hash(modules: Iterable[str]) -> str:
    """Return a hash of the code of some modules; comments and docstrings count, too."""
    digest = hashlib.sha256()
    for name in sorted(modules):
        path = _file(name)
        digest.update((path.name if path else name).encode())
        digest.update(path.read_bytes() if path else b"")
    return digest.hexdigest()


def _root(name: str) -> str:
    return name.partition(".")[0]


def _file(name: str) -> Path | None:
    module = sys.modules.get(name)
    place = getattr(module, "__file__", None)
    if place is None:
        try:
            found = importlib.util.find_spec(name)
        except (ImportError, ValueError):
            return None
        place = None if found is None else found.origin
    return Path(place) if place and place.endswith(".py") else None


def _imported(name: str) -> list[str]:
    path = _file(name)
    tree = ast.parse(path.read_bytes() if path else b"")
    names: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [item.name for item in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names += [node.module, *(f"{node.module}.{item.name}" for item in node.names)]
    return names
