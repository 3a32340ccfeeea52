"""Payload sent to Ray nodes with a run's tasks: planners' code and weights, and towns.

On the node, the files have the same absolute paths as here, below a per-run folder. Relative paths
therefore keep their meaning. Received files are checked by hash, and so is all that must be
installed on every node: plant-bench itself, SUMO, the packages.
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

LARGEST = 2**31  # bytes of a planner's files together
_PACKAGE = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Requirements:
    """What a task needs to find where it runs.

    Attributes:
        agents: Planners, as given to `load_agent`.
        towns: Folders of towns.
        isolation: Keeps the planners in processes of their own.
    """

    agents: frozenset[str] = frozenset()
    towns: frozenset[Path] = frozenset()
    isolation: Isolation | None = None


@dataclass(frozen=True)
class NodePaths:
    """Where payload lies on a node.

    Attributes:
        root: Of the tree of files that travelled.
        output: Stands for the run's folder: what a task writes below it travels back.
        towns: Folders of those towns that have travelled.
    """

    root: Path
    output: Path
    towns: tuple[Path, ...] = ()

    def found(self, path: str) -> Path:
        """Return where a file of the other machine lies here."""
        return self.root / Path(path).relative_to("/")

    def planner(self, agent: str) -> str:
        """Return how a planner is named here: with the absolute paths that it has here."""

        def here(path: str) -> str:
            moved = self.found(os.path.expanduser(path))  # noqa: PTH111  Path would join again
            return str(moved) if moved.exists() else path

        return with_paths(agent, here)


@runtime_checkable
class Portable(Protocol):
    """A task that can be done on another machine."""

    @property
    def needs(self) -> Requirements:
        """What it must find there."""
        ...

    def at(self, place: NodePaths) -> "Portable":
        """Return the same task with the paths it has there."""
        ...


@dataclass(frozen=True)
class Payload:
    """What travels, and what must be as it is here.

    Attributes:
        files: Content by absolute path.
        digests: Hash of each, by the same path.
        programs: Those of them that may be executed.
        folder: The working folder, from which relative paths are meant.
        imports: Folders in which modules among the files are found.
        towns_in: Folders in which towns among the files are found.
        agents: Planners that must load there.
        known: Names and hashes of the files that make these planners.
        libraries: Names and versions of the packages that these planners compute with.
        isolation: Keeps them in processes of their own.
        towns: Checksum of each town.
        facts: Versions and hashes that must be equal.
    """

    files: Mapping[str, bytes]
    digests: Mapping[str, str]
    programs: frozenset[str]
    folder: str
    imports: tuple[str, ...]
    towns_in: tuple[str, ...]
    agents: tuple[str, ...]
    known: frozenset[tuple[str, str]]
    libraries: frozenset[str]
    isolation: Isolation | None
    towns: Mapping[str, str]
    facts: Mapping[str, str]


def pack(tasks: Iterable[Portable]) -> Payload:
    """Return what tasks need that no installation of plant-bench holds.

    Raises:
        InputError: A planner's files cannot be read, or are too large to travel.
    """
    needs = {task.needs for task in tasks}
    agents = tuple(sorted({agent for need in needs for agent in need.agents}))
    towns = sorted({town for need in needs for town in need.towns})
    isolation = next((need.isolation for need in needs if need.isolation is not None), None)
    components = [components_of(agent, loader_of(isolation)) for agent in agents]
    mine = {path.absolute() for item in components for path in item.files}
    code = {path for path in mine if not path.is_relative_to(_PACKAGE)}
    modules = {path for path in code if path.suffix == ".py"}
    code |= {near for path in modules for near in path.parent.glob("*.py")}
    code |= {path for path in (near.with_suffix(".pickle") for near in modules) if path.is_file()}
    further = [town for town in towns if not _installed(town)]
    near_towns = {path for folder in further for path in folder.iterdir() if path.is_file()}
    files = _read(code | {path.absolute() for path in near_towns})
    return Payload(
        files=files,
        digests={path: _digest(content) for path, content in files.items()},
        programs=frozenset(path for path in files if os.access(path, os.X_OK)),
        folder=str(Path.cwd()),
        imports=_import_folders(path for path in code if path.suffix == ".py"),
        towns_in=tuple(sorted({str(folder.parent.absolute()) for folder in further})),
        agents=agents,
        known=frozenset((path.name, file_hash(path)) for path in mine | code),
        libraries=frozenset(
            text for item in components for text in library_versions(item.libraries)
        ),
        isolation=None if isolation is None else isolation.elsewhere(),
        towns={town.name: town_checksum(town.name, [town.parent]) for town in towns},
        facts=facts(),
    )


def unpack(payload: Payload, place: NodePaths) -> None:
    """Write what has travelled, and check that it is what was sent.

    Raises:
        InputError: It is not.
    """
    for path, content in payload.files.items():
        if _digest(content) != payload.digests[path]:
            message = f"{path} has arrived with another content."
            raise InputError(message)
        target = place.found(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        if path in payload.programs:
            target.chmod(0o700)
    place.found(payload.folder).mkdir(parents=True, exist_ok=True)
    place.output.mkdir(parents=True, exist_ok=True)


def enter(payload: Payload, place: NodePaths) -> NodePaths:
    """Let this process find what has travelled; for a process that does nothing else.

    Returns:
        The place, with the towns that are there.
    """
    os.chdir(place.found(payload.folder))
    imports = [str(place.found(folder)) for folder in payload.imports]
    sys.path[:0] = imports
    others = [item for item in os.environ.get("PYTHONPATH", "").split(os.pathsep) if item]
    if imports or others:  # for planners in processes of their own
        os.environ["PYTHONPATH"] = os.pathsep.join([*imports, *others])
    return replace(place, towns=tuple(map(place.found, payload.towns_in)))


def check_arrived(payload: Payload, place: NodePaths) -> None:
    """Check that planners and towns are here what they are where they were sent from.

    Raises:
        InputError: One is missing or another.
    """
    for town, checksum in payload.towns.items():
        if town_checksum(town, place.towns) != checksum:
            message = f"The town '{town}' is another one."
            raise InputError(message)
    load = loader_of(payload.isolation)
    for agent in payload.agents:
        components = components_of(place.planner(agent), load)
        for path in sorted(components.files):
            if (path.name, file_hash(path)) not in payload.known:
                message = f"'{agent}' is another planner: {path.name} differs."
                raise InputError(message)
        for text in library_versions(components.libraries):
            if text not in payload.libraries:
                message = f"'{agent}' would compute with another version here: {text}."
                raise InputError(message)


@cache
def facts() -> dict[str, str]:
    """Return what must be equal on all machines of a run, for equal results."""
    found = installed_versions()
    try:
        found["onnxruntime"] = version("onnxruntime")
    except PackageNotFoundError:
        found["onnxruntime"] = "not installed"
    found["rules of the benchmark"] = rules_checksum()[:8]
    modules = filter(None, map(module_name, _PACKAGE.rglob("*.py")))
    return found | {"code of plant-bench": code_hash(modules)[:8]}


def differences(wanted: Mapping[str, str], found: Mapping[str, str]) -> str:
    """Return in words what is not equal; empty where all is.

    >>> differences({"libsumo": "1.28.0"}, {"libsumo": "1.27.0"})
    'libsumo 1.27.0 there, 1.28.0 here'
    """
    return "; ".join(
        f"{name} {found.get(name, 'unknown')} there, {value} here"
        for name, value in wanted.items()
        if found.get(name) != value
    )


def _installed(town: Path) -> bool:
    return town.parent == networks_dir()


def _read(paths: Iterable[Path]) -> dict[str, bytes]:
    found = sorted(set(paths))
    size = sum(path.stat().st_size for path in found)
    if size > LARGEST:
        message = (
            f"The files of planner and towns have {size / 2**30:.1f} GiB together: at most "
            f"{LARGEST / 2**30:.0f} travel to other machines. Install them on each of them."
        )
        raise InputError(message)
    return {str(path): path.read_bytes() for path in found}


def _import_folders(modules: Iterable[Path]) -> tuple[str, ...]:
    """Return the entries of Python's search path below which modules lie, in its order."""
    parents = {str(parent) for path in modules for parent in path.parents}
    entries = [str(Path(entry).absolute()) for entry in sys.path if entry]
    return tuple(entry for entry in dict.fromkeys(entries) if entry in parents)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
