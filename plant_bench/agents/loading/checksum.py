"""What a planner is made of, as one hash: equal hashes drive alike, so that records can be kept.

A planner's code is its module with all that this imports from plant-bench and from its own folder
or package, and the files that it lists as `files`: weights, for instance. Comments and docstrings
do not count; of the libraries that compute, versions do.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agent import Agent
from plant_bench.agents.loading.planner_spec import Kind, PlannerSpec
from plant_bench.agents.loading.registry import Loader, load_agent, planner_module
from plant_bench.errors import InputError
from plant_bench.source_code import (
    COMPUTING,
    data_files,
    file_hash,
    import_closure,
    imported_modules,
    imported_packages,
    library_versions,
    module_file,
    module_name,
)
from plant_bench.user_modules import own_files, package_files

HARMLESS = {
    "plant_bench.agents.loading": "how planners are found, and the table of them",
    "plant_bench.agents.remote": "carries a planner's answers from another process, to the bit",
    "plant_bench.data_files": "where files lie: weights are listed and hashed",
    "plant_bench.errors": "texts of messages",
    "plant_bench.text_escaping": "texts of messages",
    "plant_bench.inference_timing": "tells how long a network takes",
    "plant_bench.untrusted_files": "how files are read: weights are listed and hashed",
    "plant_bench.user_modules": "how modules of planners are found",
    "plant_bench.renamed": "texts of messages",
    "plant_bench.source_code": "makes the checksums",
    "plant_bench.atomic_files": "how files are written",
    "plant_bench.world.hazard_sketch": "how hazards are drawn in tables and pages",
}
REMOTE = (
    "plant_bench.agents.remote.remote_agent"  # stands for a command: what it is told and may answer
)


@dataclass(frozen=True)
class PlannerComponents:
    """What a planner is made of.

    Attributes:
        files: Its code and weights.
        libraries: Names of the packages that compute its decisions.
    """

    files: frozenset[Path] = frozenset()
    libraries: frozenset[str] = frozenset()


def agent_checksum(spec: str, load: Loader = load_agent) -> str:
    """Return a hash of what makes a planner drive as it does.

    Args:
        spec: Names it.
        load: Makes it; another than `load_agent` where planners live in processes of their own.

    Raises:
        InputError: There is no such planner, or a file of it cannot be read.
    """
    components = components_of(spec, load)
    lines = [PlannerSpec.parse(spec).name]
    lines += sorted(f"{path.name} {_hash(path, spec)}" for path in components.files)
    lines += library_versions(components.libraries)
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def agent_files(spec: str, load: Loader = load_agent) -> set[Path]:
    """Return the files of a planner's code and weights.

    Raises:
        InputError: There is no such planner.
    """
    return set(components_of(spec, load).files)


def components_of(spec: str, load: Loader = load_agent) -> PlannerComponents:
    """Return what a planner is made of.

    Raises:
        InputError: There is no such planner.
    """
    agent = load(spec)
    if PlannerSpec.parse(spec).kind is Kind.COMMAND:
        code = {module_file(name) for name in import_closure(REMOTE, without=_KEPT_APART)}
        return PlannerComponents(frozenset(_listed(agent) | code), _libraries(agent))
    if getattr(agent, "remote", False):  # it was told what it is made of
        return PlannerComponents(frozenset(_listed(agent)), _libraries(agent))
    return components_of_loaded(spec, agent)


def components_of_loaded(spec: str, agent: Agent) -> PlannerComponents:
    """Return what a planner is made of that has been loaded in this process."""
    kind = PlannerSpec.parse(spec).kind
    file = Path(planner_module(spec).__file__ or "")
    own = module_name(file)
    if own is not None:
        files, modules = set[Path](), {own}
    else:
        files = package_files(file) if kind is Kind.INSTALLED else own_files(file)
        code = (path for path in files if path.suffix == ".py")
        modules = {name for path in code for name in imported_modules(path)}
    libraries = imported_packages(path for path in files if path.suffix == ".py")
    closure = import_closure(*modules, without=HARMLESS)
    ours = {module_file(name) for name in closure}
    libraries |= COMPUTING & imported_packages(ours)
    ours |= {path for name in closure for path in data_files(name)}
    return PlannerComponents(frozenset(files | ours | _listed(agent)), _libraries(agent, libraries))


_KEPT_APART = {
    name: reason for name, reason in HARMLESS.items() if name != "plant_bench.agents.remote"
}


def _libraries(agent: Agent, imported: frozenset[str] = frozenset()) -> frozenset[str]:
    """Return what a planner says that it computes with; else what its code imports."""
    told = getattr(agent, "libraries", None)
    return imported if told is None else frozenset(told)


def _listed(agent: Agent) -> set[Path]:
    return {Path(item) for item in getattr(agent, "files", ())}


def _hash(path: Path, spec: str) -> str:
    if path.exists() and not path.is_file():  # a device never ends
        message = f"The agent '{spec}' lists {path}, which is no file."
        raise InputError(message)
    try:
        return file_hash(path)
    except OSError as error:
        message = f"The agent '{spec}' needs {path}: {error.strerror}."
        raise InputError(message) from error
