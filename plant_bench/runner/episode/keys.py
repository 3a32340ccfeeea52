"""Hashes of the code that an episode depends on; part of the key that names its files.

An episode's key is made of the scenario, the planner (`agents.loading.checksum`), the town and the
rules: all code that the loop of an episode imports, and the versions of the libraries that compute.
What cannot change a record is listed in `HARMLESS`, with the reason.
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
    "plant_bench.agents": "planners, and how they are found: each has a checksum of its own",
    "plant_bench.data": "writes down what was driven; reads it for data and replays",
    "plant_bench.data_files": "where files lie: towns and routes have checksums of their content",
    "plant_bench.errors": "texts of messages",
    "plant_bench.text_escaping": "texts of messages",
    "plant_bench.gc_policy": "when Python looks for cycles",
    "plant_bench.inference_timing": "tells how long a network takes; goes into timing/ alone",
    "plant_bench.untrusted_files": "how files are read: their content has checksums",
    "plant_bench.user_modules": "how modules of planners are found",
    "plant_bench.runner.collect.data_folder": "where collected data lies",
    "plant_bench.runner.episode.jobs": "what is asked for: the scenario's key holds it",
    "plant_bench.runner.episode.keys": "makes the keys",
    "plant_bench.runner.episode.outcome": "a record and its timing, side by side",
    "plant_bench.runner.episode.timing": "the clock; goes into timing/ alone",
    "plant_bench.runner.run": "the run's folder and what is said of it",
    "plant_bench.runner.workers": "which process drives",
    "plant_bench.scoring.penalties": "turns records into scores when they are read",
    "plant_bench.source_code": "makes the keys",
    "plant_bench.towns": "makes towns and routes: their content has checksums",
    "plant_bench.atomic_files": "how files are written",
    "plant_bench.world.hazard_sketch": "how hazards are drawn in tables and pages",
}


@cache
def rules_modules() -> frozenset[str]:
    """Return the modules that move and judge the world and decide what planners are shown.

    The room of the simulator is taken as a whole: it looks scripts up by their names.
    """
    return import_closure(LOOP, *modules_below(WORLD), without=HARMLESS)


@cache
def rules_checksum() -> str:
    """Return a hash of the code that moves and judges the world, and of the libraries it needs."""
    return _hash(rules_modules())


@cache
def collecting_checksum() -> str:
    """Return a hash of all code that decides collected drives, the rules included.

    That is also how towns and routes are made, who drives instead of the expert and what is
    executed instead of its answers.
    """
    without = {name for name in HARMLESS if name != "plant_bench.towns"}
    return _hash(rules_modules() | import_closure(COLLECTING, without=without))


def _hash(modules: frozenset[str]) -> str:
    packages = imported_packages(map(module_file, modules))
    versions = library_versions(NUMERICAL_PACKAGES & packages)
    return hashlib.sha256("|".join([code_hash(modules), *versions]).encode()).hexdigest()
