"""Find a planner by its registered name, its module or its file."""

import difflib
import hashlib
import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

from plant_bench.agent import Agent, Input
from plant_bench.errors import InputError

AGENTS: dict[str, str] = {
    "cruise": "plant_bench.agents.cruise:Cruise",
    "expert": "plant_bench.agents.expert:Expert",
    "expert-nearest": "plant_bench.agents.expert_nearest:expert_nearest",
    "idm": "plant_bench.agents.idm_follower:IdmFollower",
    "rule-based": "plant_bench.agents.rule_based:RuleBased",
    "sumo": "plant_bench.agents.sumo_driver:SumoDriver",
}


def load_agent(spec: str) -> Agent:
    """Return a new planner.

    Args:
        spec: A name in `AGENTS`, "package.module:Class" or "path/to/file.py:Class".

    Raises:
        InputError: There is no such planner, or it is none; says what was meant perhaps.
    """
    module_name, class_name = _split(spec)
    module = _module(module_name, spec)
    factory = getattr(module, class_name, None)
    if factory is None:
        names = [name for name, value in vars(module).items() if isinstance(value, type)]
        message = f"There is no '{class_name}' in {module_name}.{_did_you_mean(class_name, names)}"
        raise InputError(message)
    try:
        agent = factory()
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


def describe_agent(spec: str) -> str:
    """Return the first line of what a planner's class, or what makes it, says of itself.

    Raises:
        InputError: There is no such planner.
    """
    module_name, class_name = _split(spec)
    made_by = getattr(_module(module_name, spec), class_name, None)
    return (made_by.__doc__ or "").strip().partition("\n")[0]


def agent_checksum(spec: str) -> str:
    """Return a content hash of what makes a planner drive as it does.

    A built-in planner is hashed with all of `plant_bench.agents`, whose parts it is made of; an
    outsider's with every module it has loaded from its own folder (or package), and with the files
    that its class lists as `files`: its weights, for instance.

    Raises:
        InputError: There is no such planner.
    """
    module_name, class_name = _split(spec)
    module = _module(module_name, spec)
    file = Path(module.__file__ or "")
    built_in = module_name.startswith("plant_bench.agents.")
    files = set(file.parent.glob("*.py")) if built_in else _loaded_beside(file)
    files |= {Path(item) for item in getattr(getattr(module, class_name, None), "files", ())}
    digest = hashlib.sha256(class_name.encode())
    for path in sorted(files):
        digest.update(path.name.encode())
        digest.update(_content(path, spec))
    return digest.hexdigest()


def _loaded_beside(file: Path) -> set[Path]:
    """Return the files of all modules loaded from a file's folder, or from its whole package."""
    root = file.resolve().parent
    while (root / "__init__.py").is_file() and (root.parent / "__init__.py").is_file():
        root = root.parent
    loaded = (getattr(module, "__file__", None) for module in list(sys.modules.values()))
    files = {Path(name).resolve() for name in loaded if name}
    return {file.resolve()} | {path for path in files if path.is_relative_to(root)}


def _content(path: Path, spec: str) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        message = f"The agent '{spec}' needs {path}: {error.strerror}."
        raise InputError(message) from error


def _split(spec: str) -> tuple[str, str]:
    target = AGENTS.get(spec, spec)
    module_name, colon, class_name = target.rpartition(":")
    if not colon or not module_name or not class_name:
        message = (
            f"There is no agent '{spec}'.{_did_you_mean(spec, list(AGENTS))} "
            f"Agents here: {', '.join(AGENTS)}; or give package.module:Class or file.py:Class."
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
    close = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f" Did you mean '{close[0]}'?" if close else ""
