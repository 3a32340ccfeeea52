"""Planners of installed packages, found by the entry points that they declare.

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
    """What a package says of a planner in it; nothing of it has been loaded.

    Attributes:
        target: "package.module:Class".
        distribution: The package's name and version.
    """

    target: str
    distribution: str


@cache
def installed_planners() -> Mapping[str, InstalledPlanner]:
    """Return the planners of installed packages by name, in the order of their names.

    Where two packages use one name, the package that comes first in the alphabet has it.
    """
    found: dict[str, InstalledPlanner] = {}
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, _source(entry))):
        found.setdefault(entry.name, InstalledPlanner(entry.value.strip(), _source(entry)))
    return found


def _source(entry: EntryPoint) -> str:
    package = entry.dist
    return "an unknown package" if package is None else f"{package.name} {package.version}"
