"""Hashes the code that determines cached data: plant-bench's and an external learner's."""

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
    "plant_bench.runner.episode.keys": "computes keys",
    "plant_bench.source_code": "computes keys",
    "plant_bench.world.hazard_sketch": "draws hazards in tables and pages",
}


def closure_hash(*modules: str) -> str:
    """Return a hash of modules and everything that they import from plant-bench.

    For a module outside plant-bench, it covers everything that the module imports from its own
    folder or package. Comments and docstrings do not count.
    """
    paths = [path for name in modules if (path := _file(name)) is not None]
    internal = {name for path in paths if (name := module_name(path)) is not None}
    beside = [own_files(path) for path in paths if module_name(path) is None]
    external = {path for files in beside for path in files if path.suffix == ".py"}
    internal = internal.union(*map(imported_modules, external))
    lines = [code_hash(import_closure(*internal, without=HARMLESS))]
    lines += sorted(f"{path.name} {file_hash(path)}" for path in external)
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
