"""Matches CARLA's routes to imported towns, and reports where and why a route does not fit."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import ParseError

import numpy as np
import shapely
from jaxtyping import Float

from plant_bench.data_files import networks_dir, town_dir, towns_dirs_of
from plant_bench.errors import InputError, in_one_line
from plant_bench.towns.generate import NET_FILE, TOWN_FILE
from plant_bench.towns.importing.carla_routes import CarlaRoute
from plant_bench.towns.importing.lane_graph import LaneGraph
from plant_bench.towns.importing.map_conversion import MAX_OUTPUT
from plant_bench.towns.importing.matched_route import build_route
from plant_bench.towns.importing.matching import UnmatchedError, lanes_driven, match
from plant_bench.towns.importing.net_edits import net_offset
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.untrusted_files import read_text
from plant_bench.world.route import Route
from plant_bench.world.town import Town

HEADS = (
    "route", "town", "points", "worst distance", "at point", "length", "CARLA's length", "outcome"
)  # fmt: skip
FAR_GOAL = 2.0  # m beyond CARLA's last point from which on a goal is reported


@dataclass(frozen=True, eq=False)
class RouteMatch:
    """Result of matching one CARLA route.

    Attributes:
        source: CARLA's route.
        route: The matched route, without hazards; None if it does not fit.
        worst: Largest distance of a CARLA point from the matched line, metres; NaN without a line.
        point: Index of that point, or of the point where matching failed.
        reason: Why the route does not fit; empty if it does.
        beyond: Metres of the route after CARLA's last point: routes end outside junctions.
    """

    source: CarlaRoute
    route: Route | None
    worst: float
    point: int
    reason: str
    beyond: float = 0.0

    @property
    def row(self) -> list[object]:
        """The match as a row with the columns of `HEADS`."""
        worst = "-" if np.isnan(self.worst) else f"{self.worst:.2f} m"
        place = self.source.points[self.point]
        where = f" (x {place[0]:.1f}, y {-place[1]:.1f})" if self.reason else ""
        outcome = f"unmatched: {self.reason}{where}" if self.reason else "matched"
        if self.route is not None and self.beyond > FAR_GOAL:
            outcome = f"matched; the goal is {self.beyond:.1f} m beyond CARLA's last point"
        points = len(self.source.points)
        ours = "-" if self.route is None else f"{self.route.length:.0f} m"
        theirs = f"{self.source.length:.0f} m"
        return [
            self.source.id, self.source.town, points, worst, self.point, ours, theirs, outcome
        ]  # fmt: skip


@dataclass(frozen=True)
class TownFound:
    """A town that routes are matched to, and whether the suite needs a copy of it."""

    name: str
    folder: Path
    must_copy: bool


def find_towns(pairs: Mapping[str, str], out: Path) -> dict[str, TownFound]:
    """Find towns by name or folder, in the same way as the suite will find them.

    Args:
        pairs: For each CARLA town a town's name, or a folder with a town.json.
        out: Output folder of the suite; towns in or beside it are found by name.

    Raises:
        InputError: A town does not exist, or two have the same name.
    """
    towns = {carla: _find_town(name_or_folder, out) for carla, name_or_folder in pairs.items()}
    for found in towns.values():
        shipped = networks_dir() / found.name
        others = [other.folder for other in towns.values() if other.name == found.name]
        for other in [*others, *([shipped] if shipped.is_dir() else [])]:
            if other.resolve() != found.folder.resolve():
                raise InputError(
                    f"Two towns are named '{found.name}': {other} and {found.folder}. Import one "
                    "of the maps again with another --name."
                )
    return towns


def _find_town(name_or_folder: str, out: Path) -> TownFound:
    beside = towns_dirs_of(out)
    by_folder = (Path(name_or_folder) / TOWN_FILE).is_file()
    folder = Path(name_or_folder).resolve() if by_folder else town_dir(name_or_folder, beside)
    known = {*beside, networks_dir().resolve()}
    return TownFound(folder.name, folder, folder.resolve().parent not in known)


def read_town(found: TownFound) -> Town:
    """Read a town.

    Raises:
        InputError: Its file is damaged, or the folder's name differs from the town's.
    """
    try:
        town = Town.from_json(read_text(found.folder / TOWN_FILE))
    except (InputError, OSError, ValueError) as error:
        message = f"Cannot use the town {found.folder}: {in_one_line(error)}"
        raise InputError(message) from error
    if town.name != found.name or not (found.folder / NET_FILE).is_file():
        raise InputError(f"{found.folder} is not a town's folder: import the map again.")
    return town


def match_routes(
    routes: Sequence[CarlaRoute],
    towns: Mapping[str, TownFound],
    limit: float,
    say: Callable[[str], None],
) -> list[RouteMatch]:
    """Match routes to towns.

    Args:
        routes: CARLA's routes.
        towns: The town of each CARLA town.
        limit: Maximum distance of a point from the matched line, metres.
        say: Called with a progress message for each town.

    Raises:
        InputError: A town cannot be read.
    """
    matchers: dict[str, _Matcher] = {}
    for name, found in towns.items():
        if any(route.town == name for route in routes):
            say(f"Matching {name} to {found.name}")
            matchers[name] = _Matcher(found, limit)
    done = []
    for route in routes:
        matcher = matchers.get(route.town)
        if matcher is None:
            reason = f"no --town-map for '{route.town}'"
            if not route.town:
                reason = "it names no town: use --town-map =TOWN"
            done.append(RouteMatch(route, None, float("nan"), 0, reason))
        else:
            done.append(matcher.match(route))
    return done


class _Matcher:
    """Matches routes to one town; caches its searches."""

    def __init__(self, found: TownFound, limit: float) -> None:
        self.town = read_town(found)
        self._lane_graph = LaneGraph(self.town)
        self._graph = StreetGraph(self.town)
        self._limit = limit
        self._offset = np.array([*_offset(found), 0.0])

    def match(self, source: CarlaRoute) -> RouteMatch:
        moved = replace(source, points=source.points + self._offset)
        try:
            visits = lanes_driven(self._lane_graph, match(self._lane_graph, moved, self._limit))
            route = build_route(self._graph, visits, f"{self.town.name}-{source.id}")
            route.validate()
        except UnmatchedError as error:
            return RouteMatch(source, None, float("nan"), error.point, error.reason)
        except InputError as error:
            return RouteMatch(source, None, float("nan"), 0, str(error).rstrip("."))
        away = distances(moved.points, route)
        point, worst = int(np.argmax(away)), float(away.max())
        reason = ""
        if worst > self._limit:
            larger = math.ceil(10.0 * worst + 1.0) / 10.0
            reason = f"{worst:.1f} m from the lanes; try --limit-distance {larger:g}"
        beyond = metres_beyond(route.points, moved.points[-1, :2])
        return RouteMatch(source, None if reason else route, worst, point, reason, beyond)


def _offset(found: TownFound) -> tuple[float, float]:
    net = found.folder / NET_FILE
    try:
        return net_offset(read_text(net, largest=MAX_OUTPUT))
    except (OSError, ValueError, ParseError) as error:
        raise InputError(
            f"Cannot use {net}: {in_one_line(error)}. Import the map again."
        ) from error


def distances(points: Float[np.ndarray, "points 3"], route: Route) -> Float[np.ndarray, " points"]:
    """Return the distances of points from a route's line in the plane, metres."""
    line = shapely.linestrings(route.points)
    return np.atleast_1d(shapely.distance(line, shapely.points(points[:, :2])))


def metres_beyond(line: Float[np.ndarray, "points 2"], goal: Float[np.ndarray, " 2"]) -> float:
    """Return the length of a line after it passed a point for the last time, metres."""
    away = np.hypot(*(line - goal).T)
    nearer = np.flatnonzero(np.diff(away) < 0.0)  # steps that lead towards the point
    tail = shapely.linestrings(line[nearer[-1] if len(nearer) else 0 :])
    return float(shapely.length(tail) - shapely.line_locate_point(tail, shapely.points(goal)))
