"""A planner's checksum: a hash of its code, files and library versions; the key of its records.

The code is the planner's module with its imports from plant-bench and from its own folder or
package, without comments and docstrings. The files are those in its attribute `files`, such as
weights. Of numerical libraries, the versions count.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agent import Agent
from plant_bench.agents.loading.planner_spec import Kind, PlannerSpec
from plant_bench.agents.loading.registry import Loader, load_agent, planner_module
from plant_bench.errors import InputError
from plant_bench.source_code import (
    NUMERICAL_PACKAGES,
    data_files,
    file_hash,
    import_closure,
    imported_modules,
    imported_packages,
    library_versions,
    module_file,
    module_name,
)
from plant_bench.user_code import contained, working_folder
from plant_bench.user_modules import own_files, package_files

HARMLESS = {
    "plant_bench.agents.loading": "how planners are found, and the table of planners",
    "plant_bench.agents.remote": "transfers responses from another process without change",
    "plant_bench.data_files": "where files lie: weights are listed and hashed",
    "plant_bench.errors": "texts of messages",
    "plant_bench.text_escaping": "texts of messages",
    "plant_bench.inference_timing": "measures inference times",
    "plant_bench.untrusted_files": "how files are read: weights are listed and hashed",
    "plant_bench.user_modules": "how planners' modules are found",
    "plant_bench.renamed": "texts of messages",
    "plant_bench.renamed_modules": "texts of messages",
    "plant_bench.source_code": "computes the checksums",
    "plant_bench.atomic_files": "how files are written",
    "plant_bench.world.hazard_sketch": "how hazards are drawn in tables and pages",
}
REMOTE = "plant_bench.agents.remote.remote_agent"  # plant-bench's code that a command depends on


@dataclass(frozen=True)
class PlannerComponents:
    """The files and libraries that determine a planner's behaviour.

    Attributes:
        files: Its code and weights.
        libraries: Names of the packages that it computes with.
    """

    files: frozenset[Path] = frozenset()
    libraries: frozenset[str] = frozenset()


def agent_checksum(spec: str, load: Loader = load_agent) -> str:
    """Return a planner's checksum.

    Args:
        spec: The planner's name.
        load: Creates it; differs from `load_agent` if planners run in their own processes.

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
    """Return a planner's files and libraries.

    Raises:
        InputError: There is no such planner.
    """
    with contained():
        agent = load(spec)
        folder = working_folder()
    if PlannerSpec.parse(spec).kind is Kind.COMMAND:
        code = {module_file(name) for name in import_closure(REMOTE, without=_HARMLESS_TO_COMMANDS)}
        return PlannerComponents(frozenset(_listed(agent, folder) | code), _libraries(agent))
    if getattr(agent, "remote", False):  # its process has reported all files
        return PlannerComponents(frozenset(_listed(agent, folder)), _libraries(agent))
    return components_of_loaded(spec, agent, folder)


def components_of_loaded(spec: str, agent: Agent, folder: str | None) -> PlannerComponents:
    """Return the files and libraries of a planner that was loaded in this process.

    Args:
        spec: The planner's name.
        agent: The planner.
        folder: Its working folder, which its code may have changed.
    """
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
    core = {module_file(name) for name in closure}
    libraries |= NUMERICAL_PACKAGES & imported_packages(core)
    core |= {path for name in closure for path in data_files(name)}
    files |= core | _listed(agent, folder)
    return PlannerComponents(frozenset(files), _libraries(agent, libraries))


_HARMLESS_TO_COMMANDS = {
    name: reason for name, reason in HARMLESS.items() if name != "plant_bench.agents.remote"
}


def _libraries(agent: Agent, imported: frozenset[str] = frozenset()) -> frozenset[str]:
    """Return the libraries that a planner declares; by default those that its code imports."""
    declared = getattr(agent, "libraries", None)
    return imported if declared is None else frozenset(declared)


def _listed(agent: Agent, folder: str | None) -> set[Path]:
    listed = {Path(item) for item in getattr(agent, "files", ())}
    if folder is None or folder == working_folder():
        return listed
    return {Path(folder, path) for path in listed}


def _hash(path: Path, spec: str) -> str:
    if path.exists() and not path.is_file():  # reading a device might never end
        message = f"The agent '{spec}' lists {path}, which is not a regular file."
        raise InputError(message)
    try:
        return file_hash(path)
    except OSError as error:
        message = f"The agent '{spec}' needs {path}: {error.strerror}."
        raise InputError(message) from error
