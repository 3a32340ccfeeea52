"""Registry of learners: finds them by name, entry point, module or file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from pydantic import TypeAdapter

from plant_bench.errors import InputError, did_you_mean
from plant_bench.learner import Learner
from plant_bench.user_modules import load_named

LEARNERS: dict[str, str] = {
    "plant": "plant_bench.agents.plant.learner:PlanTLearner",
}
GROUP = "plant_bench.learners"


@dataclass(frozen=True)
class LearnerSpec:
    """A learner's name and options; can be pickled and built in other processes.

    Attributes:
        name: The learner, as in `learner_class`.
        options: An instance of the learner's `Options`.
    """

    name: str
    options: Any

    def build(self) -> Learner:
        """Return the learner.

        Raises:
            InputError: There is no such learner.
        """
        return learner_class(self.name)(self.options)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle plain values: a class from a file cannot be unpickled by its module's name."""
        return _learner_spec, (self.name, asdict(self.options))


def _learner_spec(name: str, values: dict[str, Any]) -> LearnerSpec:
    kind = learner_class(name).Options
    return LearnerSpec(name, TypeAdapter(kind).validate_python(values))


def learner_class(spec: str) -> type[Learner]:
    """Return a learner's class.

    Args:
        spec: Name of a built-in or installed learner, "package.module:Class" or
            "path/to/file.py:Class".

    Raises:
        InputError: There is no such class, or it is not a learner.
    """
    module, name = _names(spec)
    found = load_named(module, name, f"learner '{spec}'")
    _check(found, spec)
    return found


@cache
def installed_learners() -> Mapping[str, str]:
    """Return "package.module:Class" of the learners that installed packages declare, by name."""
    found = sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, entry.value))
    return {entry.name: entry.value.strip() for entry in reversed(found)}


def known_learners() -> list[str]:
    """Return the names of all learners, built-in ones first."""
    return [*LEARNERS, *(name for name in sorted(installed_learners()) if name not in LEARNERS)]


def _names(spec: str) -> tuple[str, str]:
    target = LEARNERS.get(spec) or installed_learners().get(spec) or spec
    module_name, colon, class_name = target.rpartition(":")
    if not colon or not module_name or not class_name:
        known = known_learners()
        hint = did_you_mean(spec, known, cutoff=0.5, quote="'")
        message = (
            f"There is no learner '{spec}'.{hint} Known learners: {', '.join(known)}. Others are "
            "given as package.module:Class or file.py:Class."
        )
        raise InputError(message)
    return module_name, class_name


def _check(found: Any, spec: str) -> None:
    if not isinstance(found, type) or not issubclass(found, Learner):
        message = f"'{spec}' is not a learner: expected a subclass of plant_bench.learner.Learner."
        raise InputError(message)
    missing = sorted(found.__abstractmethods__) + [
        name for name in ("name", "agent", "Options") if not hasattr(found, name)
    ]
    if missing:
        message = (
            f"The learner '{spec}' does not define {', '.join(missing)}: see plant_bench.learner."
        )
        raise InputError(message)
