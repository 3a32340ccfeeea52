"""Find a planner by its name, its module, its file, or the command that runs it."""

import hashlib
import importlib
import importlib.util
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import ModuleType
from typing import Any

import plant_bench.features
from plant_bench.agent import Agent, Input
from plant_bench.agents.loading.installed import installed_planners
from plant_bench.agents.loading.planner_files import files_loaded_beside, package_files
from plant_bench.agents.remote.programs import is_command, program_of
from plant_bench.errors import InputError, did_you_mean

AGENTS: dict[str, str] = {
    "cruise": "plant_bench.agents.cruise:Cruise",
    "expert": "plant_bench.agents.expert:Expert",
    "expert-filtered": "plant_bench.agents.ranking.expert_filtered:FilteredExpert",
    "expert-nearest": "plant_bench.agents.ranking.expert_nearest:expert_nearest",
    "idm": "plant_bench.agents.idm_follower:IdmFollower",
    "plant": "plant_bench.agents.plant.guarded:GuardedPlanT",
    "plant-unguarded": "plant_bench.agents.plant.agent:PlanT",
    "rule-based": "plant_bench.agents.rule_based:RuleBased",
    "rule-based-tracks": "plant_bench.agents.rule_based_tracks:RuleBasedTracks",
    "sumo": "plant_bench.agents.sumo_driver:SumoDriver",
}

_maker: ContextVar[Callable[[str], Agent] | None] = ContextVar("who makes planners", default=None)


@contextmanager
def planners_made_by(maker: Callable[[str], Agent]) -> Iterator[None]:
    """Let `load_agent` ask somebody else for planners, who may keep them in other processes."""
    token = _maker.set(maker)
    try:
        yield
    finally:
        _maker.reset(token)


def load_agent(spec: str) -> Agent:
    """Return a new planner.

    Args:
        spec: A name in `AGENTS` or of an installed planner, "package.module:Class" or
            "path/to/file.py:Class"; what follows an "@" is given to the class as its only
            argument, as in "plant@models/mine". Or "command:PROGRAM WORDS" for a planner in
            another process (docs/protocol-agents.md).

    Raises:
        InputError: There is no such planner, or it is none; says what was meant perhaps.
    """
    maker = _maker.get()
    if maker is not None:
        return maker(spec)
    if is_command(spec):
        return _commanded(spec)
    target, argument = _split(spec)
    factory = agent_factory(target)
    try:
        agent = factory() if argument is None else factory(argument)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        message = f"The agent '{spec}' cannot be made: {type(error).__name__}: {error}"
        raise InputError(message) from error
    if not isinstance(agent, Agent):
        message = f"'{spec}' is no agent: inputs, reset and act are wanted (plant_bench/agent.py)."
        raise InputError(message)
    if not all(item in set(Input) for item in agent.inputs):
        message = f"'{spec}' declares inputs {agent.inputs!r}: choose from {', '.join(Input)}."
        raise InputError(message)
    return agent


def describe_agent(spec: str) -> tuple[str, frozenset[Input]]:
    """Return the first line of what a planner says of itself, and what it wants to be given.

    A class that declares its inputs is not made: it may want weights that are not there.

    Raises:
        InputError: There is no such planner.
    """
    made_by = agent_factory(spec)
    inputs = getattr(made_by, "inputs", None)
    about = (made_by.__doc__ or "").strip().partition("\n")[0]
    return about, load_agent(spec).inputs if inputs is None else inputs


def agent_factory(spec: str) -> Any:
    """Return a planner's class, or the function that makes it, without making one.

    Raises:
        InputError: There is no such class.
    """
    module_name, class_name = _names(_split(spec)[0])
    module = _module(module_name, spec)
    factory = getattr(module, class_name, None)
    if factory is None:
        names = [name for name, value in vars(module).items() if isinstance(value, type)]
        message = f"There is no '{class_name}' in {module_name}.{_did_you_mean(class_name, names)}"
        raise InputError(message)
    return factory


def own_module(spec: str) -> str:
    """Return the module of one of plant-bench's own planners; "" for any other."""
    return AGENTS.get(spec.partition("@")[0], "").partition(":")[0]


def agent_checksum(spec: str) -> str:
    """Return a content hash of what makes a planner drive as it does: of all its `agent_files`.

    Raises:
        InputError: There is no such planner.
    """
    name = spec if is_command(spec) else _names(_split(spec)[0])[1]
    digest = hashlib.sha256(name.encode())
    for path in sorted(agent_files(spec)):
        digest.update(path.name.encode())
        digest.update(_content(path, spec))
    return digest.hexdigest()


def agent_files(spec: str) -> set[Path]:
    """Return the files of what makes a planner drive as it does.

    For a built-in planner these are all modules of `plant_bench.agents`, whose parts it is made of,
    of its own package in there, of `plant_bench.features`, and `plant_bench.compiled`; for an
    installed planner all modules of its package; for any other every module it has loaded from its
    own folder (or package); for a command those of its words that are files. For each also the
    files that it, or its class, lists as `files`: its weights, for instance.

    Raises:
        InputError: There is no such planner.
    """
    agent = load_agent(spec)
    if is_command(spec) or _maker.get() is not None:
        return _listed(agent)  # all of them are told from the other process
    return files_of(spec, agent)


def files_of(spec: str, agent: Agent) -> set[Path]:
    """Return the files of a planner that has been loaded in this process; as `agent_files`."""
    target = _split(spec)[0]
    module_name, _ = _names(target)
    file = Path(_module(module_name, spec).__file__ or "")
    if module_name.startswith("plant_bench.agents."):
        agents = Path(__file__).parents[1]
        folders = {
            agents,
            agents / "careful",
            agents / "ranking",
            file.parent,
            Path(plant_bench.features.__file__).parent,
        }
        files = {path for folder in folders for path in folder.glob("*.py")}
        files.add(Path(plant_bench.__file__).parent / "compiled.py")
    elif ":" not in target:
        files = package_files(file)
    else:
        files = files_loaded_beside(file)
    return files | _listed(agent)


def _listed(agent: Agent) -> set[Path]:
    return {Path(item) for item in getattr(agent, "files", ())}


def _commanded(spec: str) -> Agent:
    from plant_bench.agents.remote.agent import remote_agent
    from plant_bench.agents.remote.process import Limits

    return remote_agent(program_of(spec), Limits())


def _content(path: Path, spec: str) -> bytes:
    if path.exists() and not path.is_file():  # a device never ends
        message = f"The agent '{spec}' lists {path}, which is no file."
        raise InputError(message)
    try:
        return path.read_bytes()
    except OSError as error:
        message = f"The agent '{spec}' needs {path}: {error.strerror}."
        raise InputError(message) from error


def _split(spec: str) -> tuple[str, str | None]:
    """Return what names the class, and what follows the "@" after it."""
    name, at, argument = spec.partition("@")
    if at and (name in AGENTS or ":" not in spec):
        return name, argument
    found = re.fullmatch(r"(.+?:\w+)@(.+)", spec)
    return (found[1], found[2]) if found else (spec, None)


def _names(target: str) -> tuple[str, str]:
    """Return the names of module and class."""
    found = AGENTS.get(target, target)
    if ":" not in found:  # built-in planners come first, whatever is installed
        found = installed_planners()[target].target if target in installed_planners() else ""
    module_name, colon, class_name = found.rpartition(":")
    if not colon or not module_name or not class_name:
        known = [*AGENTS, *(name for name in installed_planners() if name not in AGENTS)]
        message = (
            f"There is no agent '{target}'.{_did_you_mean(target, known)} "
            f"Agents here: {', '.join(known)}; or give package.module:Class or file.py:Class."
        )
        raise InputError(message)
    return module_name, class_name


def _module(name: str, spec: str) -> ModuleType:
    try:
        if name.endswith(".py"):
            return _module_from_file(Path(name))
        _find_modules_in(Path.cwd())
        return importlib.import_module(name)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        message = f"The agent '{spec}' cannot be loaded: {type(error).__name__}: {error}"
        raise InputError(message) from error


def _find_modules_in(folder: Path) -> None:
    """Let imports find what lies in a folder, as a script there could."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


def _module_from_file(path: Path) -> ModuleType:
    path = path.expanduser().resolve()
    _find_modules_in(path.parent)
    if not path.is_file():
        message = f"There is no file {path}."
        raise InputError(message)
    name = f"plant_bench_agent_{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"
    if name in sys.modules:
        return sys.modules[name]
    found = importlib.util.spec_from_file_location(name, path)
    if found is None or found.loader is None:
        message = f"{path} is no Python file."
        raise InputError(message)
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module
    try:
        found.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _did_you_mean(word: str, known: list[str]) -> str:
    return did_you_mean(word, known, cutoff=0.5, quote="'")
