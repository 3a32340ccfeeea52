"""Writes a suite of matched routes: one file per town, the table of matches, and copied towns."""

import csv
import io
import json
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from plant_bench.atomic_files import move_whole, write_whole, write_whole_text
from plant_bench.data_files import TOWNS_FOLDER
from plant_bench.errors import InputError
from plant_bench.towns.generate import NET_FILE, PICTURE_FILE, TOWN_FILE
from plant_bench.towns.importing.carla_sources import SOURCES
from plant_bench.towns.importing.route_import import HEADS, RouteMatch, TownFound, read_town
from plant_bench.towns.importing.suite_making import with_hazards
from plant_bench.towns.routes import suite_text
from plant_bench.world.route import Route

REPORT_FILE = "matching.csv"


def save_matches(
    matches: Sequence[RouteMatch],
    towns: Sequence[TownFound],
    out: Path,
    *,
    seed: int | None,
    overwrite: bool,
) -> int:
    """Write the matched routes as a suite, with a table of all routes.

    Args:
        matches: Matches of all routes.
        towns: The towns that they were matched to.
        out: The suite's folder.
        seed: Seed of the hazards; None for routes without hazards.
        overwrite: Replace the files of an existing suite.

    Returns:
        Number of matched routes; if it is 0, nothing is written.

    Raises:
        InputError: `out` is not empty, or two routes have the same name.
    """
    refuse_existing(out, overwrite=overwrite)
    routes = _unique_routes(matches)
    if not routes:
        return 0
    parent = out.resolve().parent if not out.exists() else out
    parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=parent, prefix=".importing-") as scratch:
        work = Path(scratch) / "new"
        work.mkdir()
        for found in dict.fromkeys(towns):  # several CARLA towns may map to one
            own = [route for route in routes if route.town == found.name]
            _write_town(found, own, work, out, seed, _sources(matches))
        write_whole_text(work / REPORT_FILE, _table(matches))
        if not out.exists():
            move_whole(work, out)
        else:
            _move_into(work, out)
    return len(routes)


def _unique_routes(matches: Sequence[RouteMatch]) -> list[Route]:
    routes = {m.route.id: m.route for m in matches if m.route is not None}
    for item in matches:
        if item.route is not None and routes[item.route.id] is not item.route:
            raise InputError(
                f"Two routes have the name {item.route.id}: import the map again with another "
                f"--name, and use that name for {item.source.town} in --town-map."
            )
    return list(routes.values())


def refuse_existing(out: Path, *, overwrite: bool) -> None:
    """Check that a suite may be written.

    Raises:
        InputError: `out` is a file, or is not empty.
    """
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out} is a file, expected a folder.")
    if out.exists() and any(out.iterdir()) and not overwrite:
        raise InputError(f"--out {out} is not empty: use --overwrite or another folder.")


def _sources(matches: Sequence[RouteMatch]) -> dict[str, list[str]]:
    """Return CARLA's id and town of each matched route."""
    return {m.route.id: [m.source.id, m.source.town] for m in matches if m.route is not None}


def _write_town(
    found: TownFound,
    routes: Sequence[Route],
    work: Path,
    out: Path,
    seed: int | None,
    sources: Mapping[str, list[str]],
) -> None:
    if not routes:
        return
    if seed is not None:
        routes = with_hazards(read_town(found), routes, seed)
    header = {
        "suite": out.resolve().name,
        "seed": seed,
        SOURCES: {route.id: sources[route.id] for route in routes},
    }
    file = work / f"{found.name}.json"
    write_whole_text(file, suite_text(header, routes))
    if found.must_copy:
        folder = work / TOWNS_FOLDER / found.name
        for name in (NET_FILE, TOWN_FILE, PICTURE_FILE):
            if (found.folder / name).is_file():
                write_whole(folder / name, partial(shutil.copyfile, found.folder / name))


def _move_into(work: Path, out: Path) -> None:
    """Move new files into an existing suite; delete its route files of other towns."""
    for path in out.glob("*.json"):
        if not (work / path.name).exists() and _is_of_suite(path, out.resolve().name):
            path.unlink()
    for path in sorted(work.rglob("*")):
        place = out / path.relative_to(work)
        if path.is_dir():
            place.mkdir(exist_ok=True)
        else:
            move_whole(path, place)


def _is_of_suite(path: Path, suite: str) -> bool:
    with path.open("rb") as file:
        head = file.readline(1000)
    return f'"suite":{json.dumps(suite)},'.encode() in head


def _table(matches: Sequence[RouteMatch]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADS)
    writer.writerows(item.row for item in matches)
    return text.getvalue()
