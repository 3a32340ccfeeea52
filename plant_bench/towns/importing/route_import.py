"""CARLA's route files onto towns: each route matched or named with where and why not."""

import csv
import io
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from jaxtyping import Float

from plant_bench.data_files import TOWNS_FOLDER, networks_dir, town_dir, towns_dirs_of
from plant_bench.errors import InputError
from plant_bench.towns.generate import NET_FILE, PICTURE_FILE, TOWN_FILE
from plant_bench.towns.importing.carla_routes import CarlaRoute
from plant_bench.towns.importing.lane_ways import LaneWays
from plant_bench.towns.importing.matched_route import build_route
from plant_bench.towns.importing.matching import UnmatchedError, lanes_driven, match
from plant_bench.towns.importing.net_edits import net_offset
from plant_bench.towns.importing.suite_making import with_hazards
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.routes import suite_text
from plant_bench.world.route import Route
from plant_bench.world.town import Town

REPORT_FILE = "matching.csv"
HEADS = ("route", "town", "points", "worst distance", "at point", "outcome")


@dataclass(frozen=True, eq=False)
class RouteMatch:
    """How a route of CARLA's fits.

    Attributes:
        source: CARLA's route.
        route: Ours, without hazards; None where it does not fit.
        worst: Metres from a point of CARLA's to our line at most; NaN where there is no line.
        point: Which point that is, or at which the matching failed.
        why: Why it does not fit; empty where it does.
    """

    source: CarlaRoute
    route: Route | None
    worst: float
    point: int
    why: str

    @property
    def row(self) -> list[object]:
        """The match as a row under `HEADS`."""
        worst = "-" if np.isnan(self.worst) else f"{self.worst:.2f} m"
        place = self.source.points[self.point]
        where = f" (x {place[0]:.1f}, y {-place[1]:.1f})" if self.why else ""
        outcome = f"unmatched: {self.why}{where}" if self.why else "matched"
        points = len(self.source.points)
        return [self.source.id, self.source.town, points, worst, self.point, outcome]


@dataclass(frozen=True)
class TownFound:
    """A town that routes are matched to, and whether the suite must take it along."""

    name: str
    folder: Path
    brought: bool


def find_town(given: str, out: Path) -> TownFound:
    """Find a town by its name or its folder.

    Args:
        given: A name, or a folder with a town.json.
        out: The suite's folder that is to be written; towns in or beside it are found by name.

    Raises:
        InputError: There is no such town.
    """
    beside = towns_dirs_of(out)
    if (Path(given) / TOWN_FILE).is_file():
        folder = Path(given).resolve()
    else:
        places = (place / given for place in beside if "/" not in given and given)
        folder = next((place for place in places if (place / TOWN_FILE).is_file()), None)
        folder = town_dir(given) if folder is None else folder
    found = {*beside, networks_dir().resolve()}
    return TownFound(folder.name, folder, folder.resolve().parent not in found)


def read_town(found: TownFound) -> Town:
    """Read a town that was found.

    Raises:
        InputError: Its file is broken, or the folder has another name than the town.
    """
    town = Town.from_json((found.folder / TOWN_FILE).read_text(encoding="utf-8"))
    if town.name != found.name or not (found.folder / NET_FILE).is_file():
        raise InputError(f"{found.folder} is no town's folder: import the map again.")
    return town


def match_routes(
    routes: Sequence[CarlaRoute],
    towns: Mapping[str, TownFound],
    limit: float,
    say: Callable[[str], None],
) -> list[RouteMatch]:
    """Match routes to towns.

    Args:
        routes: CARLA's.
        towns: For each of CARLA's towns ours.
        limit: Metres that a point may be from the matched line.
        say: Told each town.

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
            why = f"no --town-map for '{route.town}'"
            done.append(RouteMatch(route, None, float("nan"), 0, why))
        else:
            done.append(matcher.match(route))
    return done


class _Matcher:
    """Matches routes to one town; keeps what it has worked out."""

    def __init__(self, found: TownFound, limit: float) -> None:
        self.town = read_town(found)
        self._ways = LaneWays(self.town)
        self._graph = StreetGraph(self.town)
        self._limit = limit
        net = (found.folder / NET_FILE).read_text(encoding="utf-8")
        self._offset = np.array([*net_offset(net), 0.0])

    def match(self, source: CarlaRoute) -> RouteMatch:
        moved = replace(source, points=source.points + self._offset)
        try:
            visits = lanes_driven(self._ways, match(self._ways, moved))
            route = build_route(self._graph, visits, f"{self.town.name}-{source.id}")
            route.validate()
        except UnmatchedError as error:
            return RouteMatch(source, None, float("nan"), error.point, error.why)
        except InputError as error:
            return RouteMatch(source, None, float("nan"), 0, str(error).rstrip("."))
        away = distances(moved.points, route)
        point, worst = int(np.argmax(away)), float(away.max())
        why = "" if worst <= self._limit else f"farther than {self._limit:g} m from the lanes"
        return RouteMatch(source, route if not why else None, worst, point, why)


def distances(points: Float[np.ndarray, "points 3"], route: Route) -> Float[np.ndarray, " points"]:
    """Return how far points are from a route's line, metres in the plane."""
    line = shapely.linestrings(route.points)
    return np.atleast_1d(shapely.distance(line, shapely.points(points[:, :2])))


def save_matches(
    matches: Sequence[RouteMatch],
    towns: Sequence[TownFound],
    out: Path,
    *,
    seed: int | None,
    overwrite: bool,
) -> int:
    """Write the suite of the routes that were matched, with a table of all.

    Args:
        matches: All routes.
        towns: The towns that they were matched to.
        out: The suite's folder.
        seed: Of the hazards; None for routes without.
        overwrite: Replace files of a suite that is there.

    Returns:
        How many routes were matched; if none, nothing is written.

    Raises:
        InputError: There is something at `out` already.
    """
    refuse_existing(out, overwrite=overwrite)
    routes = [match.route for match in matches if match.route is not None]
    if not routes:
        return 0
    parent = out.resolve().parent if not out.exists() else out
    parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=parent, prefix=".importing-") as scratch:
        work = Path(scratch) / "new"
        work.mkdir()
        for found in towns:
            _write_town(found, [r for r in routes if r.town == found.name], work, out, seed)
        text = _table(matches)
        (work / REPORT_FILE).write_text(text, encoding="utf-8", newline="\n")
        if not out.exists():
            work.rename(out)
        else:
            _move_into(work, out)
    return len(routes)


def refuse_existing(out: Path, *, overwrite: bool) -> None:
    """Check that a suite may be written.

    Raises:
        InputError: There is something at `out` already.
    """
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out} is a file: give a folder.")
    if out.exists() and any(out.iterdir()) and not overwrite:
        raise InputError(f"--out {out} is not empty: give --overwrite, or another folder.")


def _write_town(
    found: TownFound, routes: Sequence[Route], work: Path, out: Path, seed: int | None
) -> None:
    if not routes:
        return
    if seed is not None:
        routes = with_hazards(read_town(found), routes, seed)
    about = {"suite": out.resolve().name, "seed": seed}
    file = work / f"{found.name}.json"
    file.write_text(suite_text(about, routes), encoding="utf-8", newline="\n")
    if found.brought:
        folder = work / TOWNS_FOLDER / found.name
        folder.mkdir(parents=True)
        for name in (NET_FILE, TOWN_FILE, PICTURE_FILE):
            if (found.folder / name).is_file():
                (folder / name).write_bytes((found.folder / name).read_bytes())


def _move_into(work: Path, out: Path) -> None:
    for path in sorted(work.rglob("*")):
        place = out / path.relative_to(work)
        if path.is_dir():
            place.mkdir(exist_ok=True)
        else:
            path.replace(place)


def _table(matches: Sequence[RouteMatch]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADS)
    writer.writerows(match.row for match in matches)
    return text.getvalue()
