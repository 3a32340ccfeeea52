"""Makes a town from a map file, and writes its files and routes.

```
OUT/towns/NAME/   town.net.xml, town.json, picture.png, import.json, import.md
OUT/routes/NAME.json
```

Everything is computed before anything is written; the files appear atomically.
"""

import json
import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plant_bench.atomic_files import move_whole, write_whole_text
from plant_bench.data_files import ROUTES_FOLDER, TOWNS_FOLDER, networks_dir
from plant_bench.errors import InputError, in_one_line
from plant_bench.towns.generate import NET_FILE, PICTURE_FILE, TOWN_FILE
from plant_bench.towns.importing.import_report import report_markdown, report_payload
from plant_bench.towns.importing.map_checks import check
from plant_bench.towns.importing.map_conversion import sumo_errors
from plant_bench.towns.importing.map_findings import Finding, merged
from plant_bench.towns.importing.map_source import read_source
from plant_bench.towns.importing.net_edits import ends_of_edges, net_offset
from plant_bench.towns.importing.network_repair import repair_network
from plant_bench.towns.importing.suite_making import RouteRequest, make_routes
from plant_bench.towns.routes import suite_text
from plant_bench.towns.town_image import save_picture
from plant_bench.world.route import Route
from plant_bench.world.town import Life, Town

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")
LIFE = Life(
    mix={
        "car": 0.7,
        "van": 0.11,
        "truck": 0.05,
        "bus": 0.06,
        "motorcycle": 0.05,
        "bicycle": 0.03,
    },
    walkers_per_km=14.0,
    parking=0.1,
)


@dataclass(frozen=True, eq=False)
class ImportedTown:
    """A town made from a map.

    Attributes:
        town: The town.
        net: Its network, XML text.
        routes: Routes through it.
        findings: Repairs and reported problems.
        offset: Offset from the map's x and y to the town's, metres.
    """

    town: Town
    net: str
    routes: list[Route]
    findings: list[Finding]
    offset: tuple[float, float]


def check_name(name: str) -> None:
    """Check a town's name, which becomes a folder and the prefix of its routes' ids.

    Raises:
        InputError: The name is invalid, or a benchmark town has it already.
    """
    if not NAME.fullmatch(name):
        raise InputError(
            f"--name {name[:60]!r} is not a valid town name: expected a letter, then up to 39 "
            "letters (a-z), digits, '-' and '_'."
        )
    if (networks_dir() / name.lower()).exists():
        raise InputError(f"--name {name}: the benchmark has a town of that name. Use another.")


def make_imported_town(
    path: Path,
    name: str,
    routes_request: RouteRequest,
    *,
    guess_signals: bool,
    say: Callable[[str], None],
) -> ImportedTown:
    """Make a town from a map file, without writing anything.

    Raises:
        InputError: The name or the file cannot be used, or too little of the map can be driven.
    """
    check_name(name)
    routes_request.check()
    source = read_source(path)
    repaired = repair_network(source, name, guess_signals=guess_signals, say=say)
    errors = sumo_errors(repaired.net, source.file)
    if errors:
        raise InputError(
            f"SUMO cannot load the network that netconvert made of {source.file}: {errors[0]}"
        )
    say("Checking for remaining problems")
    findings = merged(
        [*repaired.findings, *check(repaired.town, source, ends_of_edges(repaired.net))]
    )
    town = replace(repaired.town, life=LIFE)
    say("Choosing routes")
    routes = make_routes(town, routes_request)
    _check_usable(town, routes, source.file)
    return ImportedTown(town, repaired.net, routes, findings, net_offset(repaired.net))


def _check_usable(town: Town, routes: Sequence[Route], file: str) -> None:
    """Check that the town and routes can be read again once they are written.

    Raises:
        InputError: The map has an invalid position or number.
    """
    try:
        again = Town.from_json(town.to_json())
        for route in routes:
            Route.from_payload(json.loads(json.dumps(route.to_payload()))).check_town(again)
    except (InputError, ValueError) as error:
        raise InputError(
            f"{file} makes a town that cannot be used ({in_one_line(error)}): repair the map in "
            "netedit, or cut out another part."
        ) from error


def save_imported_town(made: ImportedTown, out: Path, request: dict, *, overwrite: bool) -> Path:
    """Write a town and its routes atomically.

    Args:
        made: The town.
        out: Output folder, which may contain other towns.
        request: Settings of the import, kept in import.json.
        overwrite: Replace a town of this name.

    Returns:
        The folder of the routes.

    Raises:
        InputError: The town exists already.
    """
    folder, routes = paths_in(out, made.town.name)
    refuse_existing(out, made.town.name, overwrite=overwrite)
    fresh = not out.exists()
    parent = out.resolve().parent if fresh else out
    parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=parent, prefix=".importing-") as scratch:
        work = Path(scratch) / "new"
        new_folder, new_routes = paths_in(work, made.town.name)
        _write(made, new_folder, new_routes, request)
        if fresh:
            move_whole(work, out)
            return routes.parent
        for place in (folder, routes):
            place.parent.mkdir(parents=True, exist_ok=True)
        _replace_folder(new_folder, folder, Path(scratch) / "old")
        move_whole(new_routes, routes)
    return routes.parent


def _replace_folder(new: Path, place: Path, aside: Path) -> None:
    """Move a folder to its place; a folder already there is restored if that fails."""
    if place.exists():
        place.rename(aside)
    try:
        move_whole(new, place)
    except BaseException:
        if aside.exists() and not place.exists():
            aside.rename(place)
        raise


def paths_in(out: Path, name: str) -> tuple[Path, Path]:
    """Return the folder of a town and the file of its routes."""
    return out / TOWNS_FOLDER / name, out / ROUTES_FOLDER / f"{name}.json"


def refuse_existing(out: Path, name: str, *, overwrite: bool) -> None:
    """Check that a town may be written.

    Raises:
        InputError: A town of this name exists, or `out` is not a folder.
    """
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out} is a file, expected a folder.")
    for place in paths_in(out, name):
        if place.exists() and not overwrite:
            raise InputError(
                f"{place} exists already: use --overwrite, another --name or another --out."
            )


def _write(made: ImportedTown, folder: Path, routes: Path, request: dict) -> None:
    payload = report_payload(made.town, made.routes, made.findings, made.offset) | request
    texts = {
        folder / NET_FILE: made.net,
        folder / TOWN_FILE: made.town.to_json(),
        folder / "import.json": json.dumps(payload, indent=1) + "\n",
        folder / "import.md": report_markdown(made.town, made.routes, made.findings, request),
        routes: suite_text({"suite": made.town.name, "seed": request["seed"]}, made.routes),
    }
    for file, text in texts.items():
        write_whole_text(file, text)
    save_picture(made.town, folder / PICTURE_FILE)
