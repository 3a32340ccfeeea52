"""Finds planners of installed packages by their entry points.

[project.entry-points."plant_bench.agents"]
my-planner = "my_planner.agent:MyPlanner"
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points

GROUP = "plant_bench.agents"


@dataclass(frozen=True)
class InstalledPlanner:
    """A planner's entry point; not loaded yet.

    Attributes:
        target: "package.module:Class".
        distribution: The package's name and version.
    """

    target: str
    distribution: str


@cache
def installed_planners() -> Mapping[str, InstalledPlanner]:
    """Return the planners of installed packages by name, sorted.

    If two packages use the same name, the alphabetically first package has it.
    """
    found: dict[str, InstalledPlanner] = {}
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, _source(entry))):
        found.setdefault(entry.name, InstalledPlanner(entry.value.strip(), _source(entry)))
    return found


def _source(entry: EntryPoint) -> str:
    package = entry.dist
    return "an unknown package" if package is None else f"{package.name} {package.version}"
