"""Converts a planner (name, class or object) into a name that worker processes can load.

The name of a class in a module or file is "module:Class" or "file.py:Class". An object, or a class
defined in a notebook, is pickled with cloudpickle into a folder named after its fingerprint, beside
a module that loads it.

reports/planners/<fingerprint>/<Class>.py      loads a fresh copy for each episode
reports/planners/<fingerprint>/<Class>.pickle  the class or the object
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

from plant_bench.agent import Agent
from plant_bench.agents.loading.planner_spec import AGENTS, PlannerSpec
from plant_bench.atomic_files import write_whole, write_whole_text
from plant_bench.errors import InputError, in_one_line
from plant_bench.runner.run.score_run import ScoreRequest
from plant_bench.user_modules import forget_file

PlannerLike = str | Agent | Callable[..., Agent]
PICKLED_PLANNERS = Path("reports") / "planners"
FINGERPRINT_LENGTH = 8  # characters of a fingerprint in file names and titles

_LOADER = '''"""Loads a planner pickled by plant-bench; generated file."""

from pathlib import Path

import cloudpickle

FINGERPRINT = "{fingerprint}"  # hash of the pickled planner; part of the planner's checksum


def {name}():
    """{description}"""
    planner = cloudpickle.loads(Path(__file__).with_suffix(".pickle").read_bytes())
    return planner() if {is_factory} else planner
'''


@dataclass(frozen=True)
class ResolvedPlanner:
    """A planner that workers can load.

    Attributes:
        spec: Name for `load_agent`.
        title: Name of the planner in run folders; empty if it equals `spec`.
    """

    spec: str
    title: str = ""

    def run_folder(self, request: ScoreRequest) -> Path | None:
        """Return the default folder of a run; None if `spec` determines it."""
        if not self.title:
            return None
        return Path("reports") / replace(request, agent=self.title).run_name


def resolve(planner: object) -> ResolvedPlanner:
    """Return a planner that workers can load; pickle it if it has no importable name.

    If the argument names a file, the file is loaded again, because it may have changed.

    Raises:
        InputError: The argument is not a planner, or cannot be pickled.
    """
    if isinstance(planner, str):
        forget_file(PlannerSpec.parse(planner).module)
        return ResolvedPlanner(planner)
    if not is_planner_factory(planner):
        check_planner(planner)
        return _write_planner(planner, type(planner).__name__)
    spec = importable_name(planner)
    name = getattr(planner, "__name__", type(planner).__name__)
    return _write_planner(planner, name) if spec is None else ResolvedPlanner(spec)


def is_planner_factory(planner: object) -> bool:
    """Return whether an object creates planners when called: a class or a function."""
    return isinstance(planner, type) or (callable(planner) and not isinstance(planner, Agent))


def check_planner(planner: object) -> Agent:
    """Return the argument, checked to be a planner.

    Raises:
        InputError: It is not a planner.
    """
    if not isinstance(planner, Agent):
        message = (
            "planner: expected a name, a class or an object with inputs, reset and act, got a "
            f"{type(planner).__name__}."
        )
        raise InputError(message)
    return planner


def spec_of(planner: PlannerLike, what: str) -> str:
    """Return the importable name of a planner.

    Args:
        planner: The planner.
        what: Name of the calling function, for the error message.

    Raises:
        InputError: The argument is not a planner, or has no importable name.
    """
    resolved = resolve(planner)
    if resolved.title:
        message = (
            f"{what}: expected a name or a class of a module or file, got {resolved.title}. Put "
            "the class into a file and pass 'file.py:Class'."
        )
        raise InputError(message)
    return resolved.spec


def importable_name(planner: object) -> str | None:
    """Return the name by which other processes load a class or function; None if they cannot."""
    module = _module_of(planner)
    name = getattr(planner, "__qualname__", "")
    if module is None or getattr(module, name, None) is not planner:
        return None
    target = f"{module.__name__}:{name}"
    for built_in, location in AGENTS.items():
        if location == target:
            return built_in
    if _is_importable(module.__name__):
        return target
    file = getattr(module, "__file__", None)
    return None if file is None else f"{file}:{name}"


def _module_of(definition: object) -> ModuleType | None:
    """Return the module of a class or function; None if a notebook defines it."""
    name = getattr(definition, "__module__", None)
    return None if name in (None, "__main__") else sys.modules.get(name)


def _is_importable(module: str) -> bool:
    """Return whether another process can import a module by its name."""
    parent = module.rpartition(".")[0]
    if parent and not _is_importable(parent):
        return False
    path = getattr(sys.modules.get(parent), "__path__", None) if parent else None
    finders = (getattr(finder, "find_spec", None) for finder in sys.meta_path)
    return any(find(module, path) is not None for find in finders if find is not None)


def _write_planner(planner: object, name: str) -> ResolvedPlanner:
    from plant_bench.api.fingerprint import fingerprint

    if not name.isidentifier():
        message = f"planner: expected a class or function with a name, got {name}."
        raise InputError(message)
    try:
        content = _pickled(planner)
    except Exception as error:  # attributes that cannot be pickled raise various errors
        message = (
            f"{name} cannot be sent to worker processes, because it cannot be pickled "
            f"({type(error).__name__}: {in_one_line(error)}). Create such attributes in `reset`, "
            "or put the class into a file."
        )
        raise InputError(message) from error
    digest = fingerprint(planner)
    file = PICKLED_PLANNERS / digest[:FINGERPRINT_LENGTH] / f"{name}.py"
    is_factory = is_planner_factory(planner)
    text = _LOADER.format(
        fingerprint=digest,
        name=name,
        is_factory=is_factory,
        description="Return a new planner." if is_factory else "Return a copy of the planner.",
    )
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file.with_suffix(".pickle"), lambda part: part.write_bytes(content))
        write_whole_text(file, text)
    except OSError as error:
        message = f"Cannot write {file}: {error.strerror}."
        raise InputError(message) from error
    return ResolvedPlanner(f"{file.as_posix()}:{name}", f"{name}-{digest[:FINGERPRINT_LENGTH]}")


def _pickled(planner: object) -> bytes:
    """Pickle a planner; include its module's code if other processes cannot import the module."""
    import cloudpickle

    module = _module_of(planner if is_planner_factory(planner) else type(planner))
    if module is None or _is_importable(module.__name__):
        return cloudpickle.dumps(planner)
    cloudpickle.register_pickle_by_value(module)
    try:
        return cloudpickle.dumps(planner)
    finally:
        cloudpickle.unregister_pickle_by_value(module)
