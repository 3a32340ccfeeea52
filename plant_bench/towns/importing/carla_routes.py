"""Route files of CARLA's leaderboard, 1.0 and 2.0: left-handed, y down, degrees."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from plant_bench.errors import InputError
from plant_bench.towns.importing.safe_xml import read_limited, scan_xml

MOST_BYTES = 50 * 2**20
MOST_ROUTES = 5000
MOST_POINTS = 5000  # of a route
MOST_POINTS_IN_ALL = 200_000  # matched in about a minute
FARTHEST = 1e6  # m
_WANTED = "a file of <routes><route id town><waypoint x y z yaw/></route></routes> is wanted"


@dataclass(frozen=True, eq=False)
class CarlaRoute:
    """A route as CARLA's leaderboard has it, in right-handed coordinates.

    Attributes:
        id: Of letters, digits, '.', '_' and '-'.
        town: CARLA's name of the town.
        points: x east, y north (CARLA's y, turned round), z; metres, before any offset of a map.
        headings: Radians counter-clockwise; NaN where the file does not tell.
    """

    id: str
    town: str
    points: Float[np.ndarray, "points 3"]
    headings: Float[np.ndarray, " points"]


def read_carla_routes(path: Path) -> list[CarlaRoute]:
    """Read a route file of CARLA's leaderboard, 1.0 (waypoint) or 2.0 (waypoints/position).

    Raises:
        InputError: It is missing, no such file, damaged, hostile, or a value is no number.
    """
    if not path.is_file():
        raise InputError(f"There is no route file {path}: {_WANTED}.")
    reader = _Reader(path)
    scan_xml(read_limited(path, MOST_BYTES), path, reader.enter, reader.leave)
    if not reader.routes:
        raise InputError(f"{path} holds no routes: {_WANTED}.")
    return reader.routes


class _Reader:
    """Puts routes together while a file is scanned; mutable."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._above: list[str] = []
        self._route: tuple[str, str] | None = None
        self._rows: list[list[float]] = []
        self._points = 0
        self.routes: list[CarlaRoute] = []

    def enter(self, name: str, attributes: Mapping[str, str]) -> None:
        if not self._above and name != "routes":
            raise InputError(f"{self._path} begins with <{name[:40]}>: {_WANTED}.")
        above = self._above[-1] if self._above else ""
        self._above.append(name)
        if name == "route":
            self._begin(attributes)
        elif (above, name) in (("route", "waypoint"), ("waypoints", "position")):
            self._add(attributes)

    def leave(self, name: str) -> None:
        self._above.pop()
        if name == "route":
            self._end()

    def _begin(self, attributes: Mapping[str, str]) -> None:
        number = len(self.routes)
        if number >= MOST_ROUTES:
            raise InputError(f"{self._path} holds more than {MOST_ROUTES} routes: split it.")
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", attributes.get("id", ""))[:60].strip("._-")
        if not name:
            raise InputError(f"{self._path}: route {number} has no id: {_WANTED}.")
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
        if len(self._rows) > MOST_POINTS:
            raise InputError(f"{self._path}: a route of more than {MOST_POINTS} points.")
        self._points += 1
        if self._points > MOST_POINTS_IN_ALL:
            raise InputError(f"{self._path} holds more than {MOST_POINTS_IN_ALL} points: split it.")

    def _number(self, text: str | None) -> float:
        try:
            value = float(text if text is not None else "")
        except ValueError:
            value = math.nan
        if not abs(value) <= FARTHEST:
            name = self._route[0] if self._route else "?"
            raise InputError(
                f"{self._path}: route {name}, point {len(self._rows)}: x, y and yaw must be "
                f"numbers, {(text or 'nothing')[:40]!r} found."
            )
        return value

    def _end(self) -> None:
        if self._route is None:
            return
        name, town = self._route
        if len(self._rows) < 2:
            raise InputError(
                f"{self._path}: route {name} has {len(self._rows)} points, two or more are wanted."
            )
        if any((name, town) == (route.id, route.town) for route in self.routes):
            raise InputError(f"{self._path}: there are two routes {name} in {town or 'no town'}.")
        rows = np.array(self._rows)
        self.routes.append(CarlaRoute(name, town, rows[:, :3], rows[:, 3]))
        self._route = None
