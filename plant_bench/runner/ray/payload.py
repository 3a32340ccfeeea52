"""Payload sent to Ray nodes with a run's tasks: planners' code and weights, and towns.

On the node, the files have the same absolute paths as here, below a folder of the actor, so that
relative paths remain valid. Received files are checked by hash. What must be installed on every
node (plant-bench, SUMO, the packages) is checked by version or hash.
"""

import hashlib
import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Protocol, runtime_checkable

from plant_bench.agents.loading.checksum import components_of
from plant_bench.agents.loading.planner_spec import with_paths
from plant_bench.data_files import networks_dir
from plant_bench.errors import InputError
from plant_bench.runner.episode.keys import rules_checksum
from plant_bench.runner.run.provenance import installed_versions
from plant_bench.runner.workers.isolation import Isolation, loader_of
from plant_bench.source_code import code_hash, file_hash, library_versions, module_name
from plant_bench.world.town import town_checksum

MAX_BYTES = 2**31  # total size of the files
_PACKAGE = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Requirements:
    """Files that a task requires on another machine.

    Attributes:
        agents: Planners, as named for `load_agent`.
        towns: Folders of towns.
        isolation: Runs the planners in separate processes; None to load them in the workers.
    """

    agents: frozenset[str] = frozenset()
    towns: frozenset[Path] = frozenset()
    isolation: Isolation | None = None


@dataclass(frozen=True)
class NodePaths:
    """Paths of the payload on a node.

    Attributes:
        root: Folder below which the sent files have their absolute paths.
        output: Replaces the run's folder: files that a task writes below it are sent back.
        town_folders: Folders that contain the sent towns.
    """

    root: Path
    output: Path
    town_folders: tuple[Path, ...] = ()

    def on_node(self, path: str) -> Path:
        """Return the path on the node of a file of the sending machine."""
        return self.root / Path(path).relative_to("/")

    def planner(self, agent: str) -> str:
        """Return a planner's name with its paths replaced by those on the node."""

        def replaced(path: str) -> str:
            moved = self.on_node(os.path.expanduser(path))  # noqa: PTH111  expanduser of Path normalizes the path
            return str(moved) if moved.exists() else path

        return with_paths(agent, replaced)


@runtime_checkable
class Portable(Protocol):
    """A task that can run on another machine."""

    @property
    def requirements(self) -> Requirements:
        """Files that the task requires there."""
        ...

    def with_paths(self, paths: NodePaths) -> "Portable":
        """Return the same task with the paths of that machine."""
        ...


@dataclass(frozen=True)
class Payload:
    """Files sent to the nodes, and the checksums and versions that must be equal there.

    Attributes:
        files: Content by absolute path.
        digests: SHA-256 of each file, by the same path.
        executables: Paths of executable files.
        working_folder: Absolute path of the folder that relative paths start from.
        import_folders: Entries of Python's search path for the modules among the files.
        town_folders: Folders that contain the towns among the files.
        agents: Planners that must load there.
        file_hashes: Names and hashes of the files that these planners consist of.
        libraries: Names and versions of the packages that these planners compute with.
        isolation: Runs the planners in separate processes; None to load them in the workers.
        towns: Checksum by town.
        environment: Versions and hashes by name; see `environment`.
    """

    files: Mapping[str, bytes]
    digests: Mapping[str, str]
    executables: frozenset[str]
    working_folder: str
    import_folders: tuple[str, ...]
    town_folders: tuple[str, ...]
    agents: tuple[str, ...]
    file_hashes: frozenset[tuple[str, str]]
    libraries: frozenset[str]
    isolation: Isolation | None
    towns: Mapping[str, str]
    environment: Mapping[str, str]


def pack(tasks: Iterable[Portable]) -> Payload:
    """Return the files that tasks require and that plant-bench does not install.

    Raises:
        InputError: A planner's files cannot be read, or are too large to send.
    """
    required = {task.requirements for task in tasks}
    agents = tuple(sorted({agent for item in required for agent in item.agents}))
    towns = sorted({town for item in required for town in item.towns})
    isolation = next((item.isolation for item in required if item.isolation is not None), None)
    components = [components_of(agent, loader_of(isolation)) for agent in agents]
    planner_files = {path.absolute() for item in components for path in item.files}
    code = {path for path in planner_files if not path.is_relative_to(_PACKAGE)}
    modules = {path for path in code if path.suffix == ".py"}
    code |= {sibling for path in modules for sibling in path.parent.glob("*.py")}
    code |= {path for path in (item.with_suffix(".pickle") for item in modules) if path.is_file()}
    user_towns = [town for town in towns if not _installed(town)]
    town_files = {path for folder in user_towns for path in folder.iterdir() if path.is_file()}
    files = _read(code | {path.absolute() for path in town_files})
    return Payload(
        files=files,
        digests={path: _digest(content) for path, content in files.items()},
        executables=frozenset(path for path in files if os.access(path, os.X_OK)),
        working_folder=str(Path.cwd()),
        import_folders=_import_folders(path for path in code if path.suffix == ".py"),
        town_folders=tuple(sorted({str(town.parent.absolute()) for town in user_towns})),
        agents=agents,
        file_hashes=frozenset((path.name, file_hash(path)) for path in planner_files | code),
        libraries=frozenset(
            text for item in components for text in library_versions(item.libraries)
        ),
        isolation=None if isolation is None else isolation.for_other_machine(),
        towns={town.name: town_checksum(town.name, [town.parent]) for town in towns},
        environment=environment(),
    )


def unpack(payload: Payload, paths: NodePaths) -> None:
    """Write the received files after checking their hashes.

    Raises:
        InputError: A file differs from the one that was sent.
    """
    for path, content in payload.files.items():
        if _digest(content) != payload.digests[path]:
            message = f"{path} was changed in transit: its SHA-256 differs from the sender's."
            raise InputError(message)
        target = paths.on_node(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        if path in payload.executables:
            target.chmod(0o700)
    paths.on_node(payload.working_folder).mkdir(parents=True, exist_ok=True)
    paths.output.mkdir(parents=True, exist_ok=True)


def activate(payload: Payload, paths: NodePaths) -> NodePaths:
    """Make this process use the received files: sets its working folder and import paths.

    Returns:
        The paths, with the folders of the received towns.
    """
    os.chdir(paths.on_node(payload.working_folder))
    folders = [str(paths.on_node(folder)) for folder in payload.import_folders]
    sys.path[:0] = folders
    others = [item for item in os.environ.get("PYTHONPATH", "").split(os.pathsep) if item]
    if folders or others:  # for planners in separate processes
        os.environ["PYTHONPATH"] = os.pathsep.join([*folders, *others])
    return replace(paths, town_folders=tuple(map(paths.on_node, payload.town_folders)))


def check_payload(payload: Payload, paths: NodePaths) -> None:
    """Check that planners and towns are the same here as on the sending machine.

    Raises:
        InputError: One is missing or differs.
    """
    for town, checksum in payload.towns.items():
        if town_checksum(town, paths.town_folders) != checksum:
            message = f"The town '{town}' differs from the one of the run."
            raise InputError(message)
    load = loader_of(payload.isolation)
    for agent in payload.agents:
        components = components_of(paths.planner(agent), load)
        for path in sorted(components.files):
            if (path.name, file_hash(path)) not in payload.file_hashes:
                message = f"'{agent}' differs from the planner of the run: {path.name} has changed."
                raise InputError(message)
        for text in library_versions(components.libraries):
            if text not in payload.libraries:
                message = f"'{agent}' would use another version of a library here: {text}."
                raise InputError(message)


@cache
def environment() -> dict[str, str]:
    """Return versions and hashes that must be equal on all machines of a run, by name."""
    versions = installed_versions()
    try:
        versions["onnxruntime"] = version("onnxruntime")
    except PackageNotFoundError:
        versions["onnxruntime"] = "not installed"
    versions["rules of the benchmark"] = rules_checksum()[:8]
    modules = filter(None, map(module_name, _PACKAGE.rglob("*.py")))
    return versions | {"code of plant-bench": code_hash(modules)[:8]}


def differences(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """Return a text that names all differences; empty if there are none.

    >>> differences({"libsumo": "1.28.0"}, {"libsumo": "1.27.0"})
    'libsumo 1.27.0 there, 1.28.0 here'
    """
    return "; ".join(
        f"{name} {there.get(name, 'unknown')} there, {value} here"
        for name, value in here.items()
        if there.get(name) != value
    )


def _installed(town: Path) -> bool:
    return town.parent == networks_dir()


def _read(paths: Iterable[Path]) -> dict[str, bytes]:
    unique = sorted(set(paths))
    size = sum(path.stat().st_size for path in unique)
    if size > MAX_BYTES:
        message = (
            f"The files of planner and towns have {size / 2**30:.1f} GiB in total; at most "
            f"{MAX_BYTES / 2**30:.0f} GiB can be sent to other machines. "
            "Install them on each machine."
        )
        raise InputError(message)
    return {str(path): path.read_bytes() for path in unique}


def _import_folders(modules: Iterable[Path]) -> tuple[str, ...]:
    """Return the entries of Python's search path that contain the modules, in order."""
    parents = {str(parent) for path in modules for parent in path.parents}
    entries = [str(Path(entry).absolute()) for entry in sys.path if entry]
    return tuple(entry for entry in dict.fromkeys(entries) if entry in parents)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
