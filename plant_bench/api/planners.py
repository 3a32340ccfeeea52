"""A planner as a researcher has it, a name, a class or an object, as a text that workers can load.

Workers are processes of their own and load planners by text. A class of a module or a file is named
there. An object, and a class that lives in a notebook alone, is written down: with cloudpickle,
into a folder that is called by its fingerprint, beside a module that reads it back.

reports/planners/<fingerprint>/<Class>.py      loads a fresh copy for each episode
reports/planners/<fingerprint>/<Class>.pickle  the class, or the object as it was
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

from plant_bench.agent import Agent
from plant_bench.agents.loading.spec import AGENTS, PlannerSpec
from plant_bench.errors import InputError, in_one_line
from plant_bench.module_files import forget_file
from plant_bench.runner.run.score_run import ScoreRequest
from plant_bench.whole_files import write_whole, write_whole_text

PlannerLike = str | Agent | Callable[..., Agent]
WRITTEN = Path("reports") / "planners"
SHOWN = 8  # characters of a fingerprint

_LOADER = '''"""A planner handed over from Python; plant-bench wrote this."""

from pathlib import Path

import cloudpickle

FINGERPRINT = "{fingerprint}"  # of what the pickle holds: the planner's checksum covers it


def {name}():
    """{about}"""
    found = cloudpickle.loads(Path(__file__).with_suffix(".pickle").read_bytes())
    return found() if {is_factory} else found
'''


@dataclass(frozen=True)
class ResolvedPlanner:
    """A planner that workers can load.

    Attributes:
        spec: As `load_agent` takes it.
        title: What its runs are called; empty for what the text says.
    """

    spec: str
    title: str = ""

    def run_folder(self, request: ScoreRequest) -> Path | None:
        """Return where a run of it lies without another wish; None for what the text says."""
        if not self.title:
            return None
        return Path("reports") / replace(request, agent=self.title).run_name


def resolve(planner: object) -> ResolvedPlanner:
    """Return a planner as workers load it; one that they could not is written down for them.

    A file that a text names is loaded anew here, as by workers that start now.

    Raises:
        InputError: It is no planner, or cannot be handed over.
    """
    if isinstance(planner, str):
        forget_file(PlannerSpec.parse(planner).module)
        return ResolvedPlanner(planner)
    if not makes_planners(planner):
        check_planner(planner)
        return _written(planner, type(planner).__name__)
    spec = importable(planner)
    name = getattr(planner, "__name__", type(planner).__name__)
    return _written(planner, name) if spec is None else ResolvedPlanner(spec)


def makes_planners(planner: object) -> bool:
    """Tell whether something is called to have a planner: a class, a function."""
    return isinstance(planner, type) or (callable(planner) and not isinstance(planner, Agent))


def check_planner(planner: object) -> Agent:
    """Return a planner if it is one.

    Raises:
        InputError: It is none.
    """
    if not isinstance(planner, Agent):
        message = (
            "planner: expected a name, a class or an object with inputs, reset and act, got a "
            f"{type(planner).__name__}."
        )
        raise InputError(message)
    return planner


def spec_of(planner: PlannerLike, what: str) -> str:
    """Return a planner that is named in other planners or in data, where only text can be kept.

    Args:
        planner: The planner.
        what: Asks for it; for the message.

    Raises:
        InputError: It is no planner, or cannot be handed over.
    """
    resolved = resolve(planner)
    if resolved.title:
        message = (
            f"{what}: expected a name or a class of a module or file, got {resolved.title}. Put "
            "the class into a file, and give 'file.py:Class'."
        )
        raise InputError(message)
    return resolved.spec


def importable(planner: object) -> str | None:
    """Return the text that names a class or function in a process of its own; None if none does."""
    module = _module_of(planner)
    name = getattr(planner, "__qualname__", "")
    if module is None or getattr(module, name, None) is not planner:
        return None
    target = f"{module.__name__}:{name}"
    for known, ours in AGENTS.items():
        if ours == target:
            return known
    if _is_found(module.__name__):
        return target
    file = getattr(module, "__file__", None)
    return None if file is None else f"{file}:{name}"


def _module_of(thing: object) -> ModuleType | None:
    """Return the module that a class or function is defined in; None in a notebook."""
    name = getattr(thing, "__module__", None)
    return None if name in (None, "__main__") else sys.modules.get(name)


def _is_found(module: str) -> bool:
    """Tell whether a process that has not loaded a module finds it by its name."""
    parent = module.rpartition(".")[0]
    if parent and not _is_found(parent):
        return False
    path = getattr(sys.modules.get(parent), "__path__", None) if parent else None
    finders = (getattr(finder, "find_spec", None) for finder in sys.meta_path)
    return any(find(module, path) is not None for find in finders if find is not None)


def _written(planner: object, name: str) -> ResolvedPlanner:
    from plant_bench.api.fingerprint import fingerprint

    if not name.isidentifier():
        message = f"planner: expected a class or function with a name, got {name}."
        raise InputError(message)
    try:
        content = _pickled(planner)
    except Exception as error:  # whatever a planner holds that cannot be copied
        message = (
            f"{name} cannot be handed to worker processes ({type(error).__name__}: "
            f"{in_one_line(error)}). Make what it holds in `reset`, or put the class into a file."
        )
        raise InputError(message) from error
    mark = fingerprint(planner)
    file = WRITTEN / mark[:SHOWN] / f"{name}.py"
    is_factory = makes_planners(planner)
    text = _LOADER.format(
        fingerprint=mark,
        name=name,
        is_factory=is_factory,
        about="Return a new planner." if is_factory else "Return a copy of the planner.",
    )
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file.with_suffix(".pickle"), lambda part: part.write_bytes(content))
        write_whole_text(file, text)
    except OSError as error:
        message = f"Cannot write {file}: {error.strerror}."
        raise InputError(message) from error
    return ResolvedPlanner(f"{file.as_posix()}:{name}", f"{name}-{mark[:SHOWN]}")


def _pickled(planner: object) -> bytes:
    """Return a planner as bytes, with its module's code where no other process finds the module."""
    import cloudpickle

    module = _module_of(planner if makes_planners(planner) else type(planner))
    if module is None or _is_found(module.__name__):
        return cloudpickle.dumps(planner)
    cloudpickle.register_pickle_by_value(module)
    try:
        return cloudpickle.dumps(planner)
    finally:
        cloudpickle.unregister_pickle_by_value(module)
