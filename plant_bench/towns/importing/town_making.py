"""An imported town on disk: its net, its lanes, its picture, its report, and routes beside it.

```
OUT/towns/NAME/   town.net.xml, town.json, picture.png, import.json, import.md
OUT/routes/NAME.json
```

All is made before anything is written, and appears whole or not at all.
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
from plant_bench.towns.importing.map_conversion import errors_of_sumo
from plant_bench.towns.importing.map_findings import Finding, merged
from plant_bench.towns.importing.map_source import read_source
from plant_bench.towns.importing.net_edits import ends_of_edges, net_offset
from plant_bench.towns.importing.network_repair import mend
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
    """A town made of a map.

    Attributes:
        town: The town.
        net: Its network, XML text.
        routes: Routes through it.
        findings: What was repaired and what is only reported.
        offset: What the map's x and y were moved by.
    """

    town: Town
    net: str
    routes: list[Route]
    findings: list[Finding]
    offset: tuple[float, float]


def check_name(name: str) -> None:
    """Check a town's name, which becomes a folder and the begin of its routes' ids.

    Raises:
        InputError: It is none, or one of the benchmark's towns has it.
    """
    if not NAME.fullmatch(name):
        raise InputError(
            f"--name {name[:60]!r} cannot be a town's name: up to 40 letters (a-z), digits, '-' "
            "and '_' are wanted, a letter first."
        )
    if (networks_dir() / name.lower()).exists():
        raise InputError(f"--name {name}: the benchmark has a town of that name. Choose another.")


def make_imported_town(
    path: Path,
    name: str,
    wanted: RouteRequest,
    *,
    guess_signals: bool,
    say: Callable[[str], None],
) -> ImportedTown:
    """Make a town of a map file; nothing is written.

    Raises:
        InputError: The name or the file cannot be used, or no town is left of it.
    """
    check_name(name)
    wanted.check()
    source = read_source(path)
    mended = mend(source, name, guess_signals=guess_signals, say=say)
    errors = errors_of_sumo(mended.net, source.file)
    if errors:
        raise InputError(f"SUMO cannot load what netconvert made of {source.file}: {errors[0]}")
    say("Looking for what is left to report")
    findings = merged([*mended.findings, *check(mended.town, source, ends_of_edges(mended.net))])
    town = replace(mended.town, life=LIFE)
    say("Choosing routes")
    routes = make_routes(town, wanted)
    _check_usable(town, routes, source.file)
    return ImportedTown(town, mended.net, routes, findings, net_offset(mended.net))


def _check_usable(town: Town, routes: Sequence[Route], file: str) -> None:
    """Check that what is going to be written can be read again.

    Raises:
        InputError: A place or number of the map is none that a town may have.
    """
    try:
        again = Town.from_json(town.to_json())
        for route in routes:
            Route.from_payload(json.loads(json.dumps(route.to_payload()))).check_town(again)
    except (InputError, ValueError) as error:
        raise InputError(
            f"{file} makes a town that cannot be used ({in_one_line(error)}): mend the map in "
            "netedit, or cut out another part."
        ) from error


def save_imported_town(made: ImportedTown, out: Path, about: dict, *, overwrite: bool) -> Path:
    """Write a town and its routes, each whole or not at all.

    Args:
        made: The town.
        out: The folder; other towns may be in it.
        about: What was asked for, kept in import.json.
        overwrite: Replace a town of this name.

    Returns:
        The folder of the routes.

    Raises:
        InputError: There is such a town already.
    """
    folder, routes = places_in(out, made.town.name)
    refuse_existing(out, made.town.name, overwrite=overwrite)
    fresh = not out.exists()
    parent = out.resolve().parent if fresh else out
    parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=parent, prefix=".importing-") as scratch:
        work = Path(scratch) / "new"
        new_folder, new_routes = places_in(work, made.town.name)
        _write(made, new_folder, new_routes, about)
        if fresh:
            move_whole(work, out)
            return routes.parent
        for place in (folder, routes):
            place.parent.mkdir(parents=True, exist_ok=True)
        _replace_folder(new_folder, folder, Path(scratch) / "old")
        move_whole(new_routes, routes)
    return routes.parent


def _replace_folder(new: Path, place: Path, aside: Path) -> None:
    """Put a folder where another may be, which comes back if that fails."""
    if place.exists():
        place.rename(aside)
    try:
        move_whole(new, place)
    except BaseException:
        if aside.exists() and not place.exists():
            aside.rename(place)
        raise


def places_in(out: Path, name: str) -> tuple[Path, Path]:
    """Return the folder of a town and the file of its routes."""
    return out / TOWNS_FOLDER / name, out / ROUTES_FOLDER / f"{name}.json"


def refuse_existing(out: Path, name: str, *, overwrite: bool) -> None:
    """Check that a town may be written.

    Raises:
        InputError: There is one of this name, or something else than a folder.
    """
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out} is a file: give a folder.")
    for place in places_in(out, name):
        if place.exists() and not overwrite:
            raise InputError(
                f"{place} is there already: give --overwrite, another --name or another --out."
            )


def _write(made: ImportedTown, folder: Path, routes: Path, about: dict) -> None:
    payload = report_payload(made.town, made.routes, made.findings, made.offset) | about
    texts = {
        folder / NET_FILE: made.net,
        folder / TOWN_FILE: made.town.to_json(),
        folder / "import.json": json.dumps(payload, indent=1) + "\n",
        folder / "import.md": report_markdown(made.town, made.routes, made.findings, about),
        routes: suite_text({"suite": made.town.name, "seed": about["seed"]}, made.routes),
    }
    for file, text in texts.items():
        write_whole_text(file, text)
    save_picture(made.town, folder / PICTURE_FILE)
