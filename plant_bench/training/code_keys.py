"""Hashes of the code that determines cached values: plant-bench's and an external learner's."""

import hashlib
import importlib.util
import sys
from pathlib import Path

from plant_bench.source_code import (
    code_hash,
    file_hash,
    import_closure,
    imported_modules,
    module_name,
)
from plant_bench.user_modules import own_files

HARMLESS = {
    "plant_bench.runner.episode.keys": "makes keys",
    "plant_bench.source_code": "makes keys",
    "plant_bench.world.hazard_sketch": "how hazards are drawn in tables and pages",
}


def closure_hash(*modules: str) -> str:
    """Return a hash of modules with all that they import from plant-bench.

    Of a module from elsewhere all counts that it imports from its own folder or package. Comments
    and docstrings do not count.
    """
    paths = [path for name in modules if (path := _file(name)) is not None]
    ours = {name for path in paths if (name := module_name(path)) is not None}
    beside = [own_files(path) for path in paths if module_name(path) is None]
    theirs = {path for files in beside for path in files if path.suffix == ".py"}
    ours = ours.union(*map(imported_modules, theirs))
    lines = [code_hash(import_closure(*ours, without=HARMLESS))]
    lines += sorted(f"{path.name} {file_hash(path)}" for path in theirs)
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def _file(name: str) -> Path | None:
    place = getattr(sys.modules.get(name), "__file__", None)
    if place is None:
        try:
            found = importlib.util.find_spec(name)
        except (ImportError, ValueError):
            return None
        place = None if found is None else found.origin
    return Path(place) if place and place.endswith(".py") else None
