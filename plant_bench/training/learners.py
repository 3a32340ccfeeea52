"""The one table of learners: found by name, by an installed package's word, by module or file."""

import hashlib
import importlib
import importlib.util
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import TypeAdapter

from plant_bench.errors import InputError, did_you_mean
from plant_bench.learner import Learner

LEARNERS: dict[str, str] = {
    "plant": "plant_bench.agents.plant.learner:PlanTLearner",
}
GROUP = "plant_bench.learners"


@dataclass(frozen=True)
class Student:
    """A learner by name and options; goes to other processes, which make it anew.

    Attributes:
        spec: As `learner_class` takes it.
        options: Of the learner's `Options`.
    """

    spec: str
    options: Any

    def learner(self) -> Learner:
        """Return it.

        Raises:
            InputError: There is no such learner.
        """
        return learner_class(self.spec)(self.options)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle plain values: a class from a file cannot be found by its module's name."""
        return _student, (self.spec, asdict(self.options))


def _student(spec: str, values: dict[str, Any]) -> Student:
    kind = learner_class(spec).Options
    return Student(spec, TypeAdapter(kind).validate_python(values))


def learner_class(spec: str) -> type[Learner]:
    """Return a learner's class.

    Args:
        spec: A name in `LEARNERS` or of an installed learner, "package.module:Class" or
            "path/to/file.py:Class".

    Raises:
        InputError: There is no such class, or it is no learner.
    """
    module_name, class_name = _names(spec)
    module = _module(module_name, spec)
    found = getattr(module, class_name, None)
    if found is None:
        names = [name for name, value in vars(module).items() if isinstance(value, type)]
        message = f"There is no '{class_name}' in {module_name}.{_hint(class_name, names)}"
        raise InputError(message)
    _check(found, spec)
    return found


@cache
def installed_learners() -> Mapping[str, str]:
    """Return "package.module:Class" of the learners that installed packages declare, by name."""
    found = sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, entry.value))
    return {entry.name: entry.value.strip() for entry in reversed(found)}


def known_learners() -> list[str]:
    """Return the names of all learners, ours first."""
    return [*LEARNERS, *(name for name in sorted(installed_learners()) if name not in LEARNERS)]


def _names(spec: str) -> tuple[str, str]:
    target = LEARNERS.get(spec) or installed_learners().get(spec) or spec
    module_name, colon, class_name = target.rpartition(":")
    if not colon or not module_name or not class_name:
        known = known_learners()
        message = (
            f"There is no learner '{spec}'.{_hint(spec, known)} Learners here: "
            f"{', '.join(known)}; or give package.module:Class or file.py:Class."
        )
        raise InputError(message)
    return module_name, class_name


def _check(found: Any, spec: str) -> None:
    if not isinstance(found, type) or not issubclass(found, Learner):
        message = f"'{spec}' is no learner: a subclass of plant_bench.learner.Learner is expected."
        raise InputError(message)
    missing = sorted(found.__abstractmethods__) + [
        name for name in ("name", "agent", "Options") if not hasattr(found, name)
    ]
    if missing:
        message = f"The learner '{spec}' lacks {', '.join(missing)}: see plant_bench/learner.py."
        raise InputError(message)


def _module(name: str, spec: str) -> ModuleType:
    try:
        if name.endswith(".py"):
            return _module_from_file(Path(name))
        _find_modules_in(Path.cwd())
        return importlib.import_module(name)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        message = f"The learner '{spec}' cannot be loaded: {type(error).__name__}: {error}"
        raise InputError(message) from error


def _find_modules_in(folder: Path) -> None:
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


def _module_from_file(path: Path) -> ModuleType:
    """Load a file under the name that planners from files have, so that one file is loaded once."""
    path = path.expanduser().resolve()
    _find_modules_in(path.parent)
    if not path.is_file():
        message = f"There is no file {path}: a Python file with a learner is expected."
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


def _hint(word: str, known: list[str]) -> str:
    return did_you_mean(word, known, cutoff=0.5, quote="'")
