"""Hashes of the code that an episode depends on; part of the key in its file names.

An episode's key covers the scenario, the planner (`agents.loading.checksum`), the town and the
rules: all code that the episode loop imports, and the versions of the numerical libraries. Modules
that cannot change a record are listed in `HARMLESS`, with the reason.
"""

import hashlib
from functools import cache

from plant_bench.source_code import (
    NUMERICAL_PACKAGES,
    code_hash,
    import_closure,
    imported_packages,
    library_versions,
    module_file,
    modules_below,
)

LOOP = "plant_bench.runner.episode.loop"
WORLD = "plant_bench.sim"
COLLECTING = "plant_bench.runner.collect.collect_task"

HARMLESS = {
    "plant_bench.agents": "planners, which have their own checksums, and how they are found",
    "plant_bench.data": "writes and reads recordings",
    "plant_bench.data_files": "paths of files: towns and routes have checksums of their content",
    "plant_bench.errors": "texts of messages",
    "plant_bench.text_escaping": "texts of messages",
    "plant_bench.gc_policy": "when the garbage collector runs",
    "plant_bench.inference_timing": "duration of a network's forward pass; only in timing/",
    "plant_bench.untrusted_files": "how files are read: their content has checksums",
    "plant_bench.user_code": "texts of messages about planners' own errors",
    "plant_bench.user_modules": "how modules of planners are found",
    "plant_bench.runner.collect.data_folder": "the folder of collected data",
    "plant_bench.runner.episode.jobs": "the request, which the scenario's key covers",
    "plant_bench.runner.episode.keys": "computes the keys",
    "plant_bench.runner.episode.outcome": "a record with its timing",
    "plant_bench.runner.episode.timing": "measured times; only in timing/",
    "plant_bench.runner.run": "the run's folder and its summaries",
    "plant_bench.runner.workers": "the process in which an episode runs",
    "plant_bench.scoring.penalties": "computes scores from records",
    "plant_bench.source_code": "computes the keys",
    "plant_bench.towns": "generates towns and routes, whose content has checksums",
    "plant_bench.atomic_files": "how files are written",
    "plant_bench.world.hazard_sketch": "how hazards are drawn in tables and pages",
}


@cache
def rules_modules() -> frozenset[str]:
    """Return the modules of the simulation, the referee and the planners' observations.

    The simulation package is included completely, since it imports hazards by name.
    """
    return import_closure(LOOP, *modules_below(WORLD), without=HARMLESS)


@cache
def rules_checksum() -> str:
    """Return a hash of the rules' code and of the versions of the libraries that it uses."""
    return _hash(rules_modules())


@cache
def collecting_checksum() -> str:
    """Return a hash of all code that affects collected data, including the rules.

    It also covers the generation of towns and routes, DAgger and the perturbations.
    """
    without = {name for name in HARMLESS if name != "plant_bench.towns"}
    return _hash(rules_modules() | import_closure(COLLECTING, without=without))


def _hash(modules: frozenset[str]) -> str:
    packages = imported_packages(map(module_file, modules))
    versions = library_versions(NUMERICAL_PACKAGES & packages)
    return hashlib.sha256("|".join([code_hash(modules), *versions]).encode()).hexdigest()
