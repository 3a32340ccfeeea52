"""Reads route files of the CARLA leaderboard, 1.0 and 2.0 (left-handed, y down, degrees)."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from plant_bench.errors import InputError
from plant_bench.towns.importing.safe_xml import read_limited, scan_xml

MAX_BYTES = 50 * 2**20
MAX_ROUTES = 5000
MAX_POINTS = 5000  # per route
MAX_POINTS_IN_FILE = 200_000  # matching them takes about a minute
MAX_COORDINATE = 1e6  # m
_POINTS = (  # parent and name of a point's element
    ("route", "waypoint"),  # leaderboard 1.0
    ("waypoints", "position"),  # leaderboard 2.0
    ("ego_vehicle", "waypoint"),  # carla-roach, NoCrash
)
_EXPECTED = "expected a file of <routes><route id town><waypoint x y z yaw/></route></routes>"


@dataclass(frozen=True, eq=False)
class CarlaRoute:
    """A route of a CARLA leaderboard file, in right-handed coordinates.

    Attributes:
        id: Letters, digits, '.', '_' and '-'.
        town: CARLA's name of the town.
        points: x east, y north (CARLA's y with its sign changed), z; metres, before any map offset.
        headings: Radians counter-clockwise; NaN where the file has none.
    """

    id: str
    town: str
    points: Float[np.ndarray, "points 3"]
    headings: Float[np.ndarray, " points"]

    @property
    def length(self) -> float:
        """Length of the straight lines between the points in the plane, metres."""
        return float(np.hypot(*np.diff(self.points[:, :2], axis=0).T).sum())


def read_carla_routes(path: Path) -> list[CarlaRoute]:
    """Read a route file of CARLA's leaderboard, 1.0 (waypoint) or 2.0 (waypoints/position).

    Raises:
        InputError: The file is missing, damaged or unsafe, or no route file, or a value is not a
            number.
    """
    if not path.is_file():
        raise InputError(f"There is no route file {path}: {_EXPECTED}.")
    reader = _Reader(path)
    scan_xml(read_limited(path, MAX_BYTES), path, reader.enter, reader.leave)
    if not reader.routes:
        raise InputError(f"{path} has no routes: {_EXPECTED}.")
    return reader.routes


class _Reader:
    """Collects routes while a file is scanned; mutable."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._ancestors: list[str] = []
        self._route: tuple[str, str] | None = None
        self._rows: list[list[float]] = []
        self._points = 0
        self.routes: list[CarlaRoute] = []

    def enter(self, name: str, attributes: Mapping[str, str]) -> None:
        if not self._ancestors and name != "routes":
            raise InputError(f"{self._path} begins with <{name[:40]}>: {_EXPECTED}.")
        parent = self._ancestors[-1] if self._ancestors else ""
        self._ancestors.append(name)
        if name == "route":
            self._begin(attributes)
        elif (parent, name) in _POINTS:
            self._add(attributes)

    def leave(self, name: str) -> None:
        self._ancestors.pop()
        if name == "route":
            self._end()

    def _begin(self, attributes: Mapping[str, str]) -> None:
        number = len(self.routes)
        if number >= MAX_ROUTES:
            raise InputError(f"{self._path} has more than {MAX_ROUTES} routes: split it.")
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", attributes.get("id", ""))[:60].strip("._-")
        if not name:
            raise InputError(f"{self._path}: route {number} has no id: {_EXPECTED}.")
        town = attributes.get("town", attributes.get("map", ""))[:60]
        self._route, self._rows = (name, town), []

    def _add(self, attributes: Mapping[str, str]) -> None:
        row = [
            self._number(attributes.get("x")),
            -self._number(attributes.get("y")),
            self._number(attributes.get("z", "0")),
            -math.radians(self._number(attributes["yaw"])) if "yaw" in attributes else math.nan,
        ]
        self._rows.append(row)
        if len(self._rows) > MAX_POINTS:
            raise InputError(
                f"{self._path}: route {self._name} has more than {MAX_POINTS} points: split it."
            )
        self._points += 1
        if self._points > MAX_POINTS_IN_FILE:
            raise InputError(f"{self._path} has more than {MAX_POINTS_IN_FILE} points: split it.")

    def _number(self, text: str | None) -> float:
        try:
            value = float(text if text is not None else "")
        except ValueError:
            value = math.nan
        if not abs(value) <= MAX_COORDINATE:
            raise InputError(
                f"{self._path}: route {self._name}, point {len(self._rows)}: x, y and yaw must be "
                f"numbers, got {(text or 'nothing')[:40]!r}."
            )
        return value

    @property
    def _name(self) -> str:
        return self._route[0] if self._route else "?"

    def _end(self) -> None:
        if self._route is None:
            return
        name, town = self._route
        if len(self._rows) < 2:
            raise InputError(
                f"{self._path}: route {name} has {len(self._rows)} points, expected two or more."
            )
        if any((name, town) == (route.id, route.town) for route in self.routes):
            raise InputError(f"{self._path}: there are two routes {name} in {town or 'no town'}.")
        rows = np.array(self._rows)
        self.routes.append(CarlaRoute(name, town, rows[:, :3], rows[:, 3]))
        self._route = None
