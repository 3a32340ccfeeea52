"""netconvert on maps of strangers: its options, and limits on its time, memory and output."""

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import sumo

from plant_bench.errors import InputError
from plant_bench.towns.importing.map_source import MapKind, MapSource
from plant_bench.towns.netconvert import without_header

TIMEOUT_S = 300
MOST_MEMORY = 4 * 2**30  # bytes
MOST_OUTPUT = 2**30
LAYER_HEIGHT = 5.0  # m between the layers of an OpenStreetMap file
OUT_OF_MEMORY = "std::bad_alloc"
NOTHING = ("No nodes loaded", "No edges loaded")  # what netconvert says of a map without roads

_COMMON = {
    "--xml-validation": "never",
    "--xml-validation.net": "never",
    "--keep-edges.by-vclass": "passenger",
    "--no-turnarounds": "true",
    "--no-internal-links": "false",
    "--junctions.internal-link-detail": "20",
    "--junctions.limit-turn-speed": "3",
    "--speed.minimum": "2.8",
    "--aggregate-warnings": "3",
}
_EXACT = {"--offset.disable-normalization": "true"}
_OF_KIND = {
    MapKind.SUMO: _EXACT,
    MapKind.OPENDRIVE: _EXACT
    | {"--opendrive.internal-shapes": "true", "--opendrive.curve-resolution": "1"},
    MapKind.OSM: {
        "--geometry.remove": "true",
        "--junctions.join": "true",
        "--ramps.guess": "true",
        "--tls.guess-signals": "true",
        "--tls.join": "true",
        "--osm.layer-elevation": f"{LAYER_HEIGHT:g}",
        "--sidewalks.guess": "true",
        "--crossings.guess": "true",
        "--default.lanewidth": "3.2",
        "--default.junctions.radius": "6",
    },
}
_INPUTS = {
    MapKind.SUMO: "--sumo-net-file",
    MapKind.OPENDRIVE: "--opendrive-files",
    MapKind.OSM: "--osm-files",
}


@dataclass(frozen=True)
class Converted:
    """What netconvert made of a map.

    Attributes:
        net: The SUMO network, XML text.
        warnings: What netconvert said, a line each.
    """

    net: str
    warnings: tuple[str, ...]


def convert_source(source: MapSource, *, guess_signals: bool) -> Converted:
    """Make a SUMO network of a map file.

    Raises:
        InputError: netconvert cannot, or not within the limits.
    """
    options = _OF_KIND[source.kind] | {_INPUTS[source.kind]: "map.xml"}
    if guess_signals:
        options["--tls.guess"] = "true"
    return _convert(source.content, options, (), source.file)


def convert_again(net: str, removed: Sequence[str], name: str) -> Converted:
    """Convert a SUMO network (XML text) again, without some edges.

    Raises:
        InputError: netconvert cannot, or not within the limits.
    """
    options = _EXACT | {_INPUTS[MapKind.SUMO]: "map.xml"}
    return _convert(net.encode(), options, removed, name)


def _convert(
    content: bytes, options: dict[str, str], removed: Sequence[str], name: str
) -> Converted:
    options = _COMMON | options | {"--output-file": "town.net.xml"}
    with tempfile.TemporaryDirectory(prefix="plant-bench-") as folder:
        (Path(folder) / "map.xml").write_bytes(content)
        if removed:
            listed = "".join(f"{edge}\n" for edge in removed)
            (Path(folder) / "removed.txt").write_text(listed, encoding="utf-8")
            options["--remove-edges.input-file"] = "removed.txt"
        run = _run("netconvert", [word for pair in options.items() for word in pair], folder, name)
        out = Path(folder) / "town.net.xml"
        lines = _lines(run.stderr)
        if run.returncode != 0 or not out.is_file():
            if any(line.startswith(NOTHING) for line in lines):
                raise InputError(f"{name} has no road that a car may drive on: take another map.")
            if OUT_OF_MEMORY in run.stderr:
                raise InputError(
                    f"netconvert needs more than {MOST_MEMORY / 2**30:.0f} GB for {name}: cut "
                    "out a smaller part of the map."
                )
            said = "; ".join(lines[:2]) or f"it ended with code {run.returncode}: mend the map"
            raise InputError(f"netconvert makes no network of {name}: {said}")
        return Converted(without_header(out.read_text(encoding="utf-8")), tuple(lines))


def errors_of_sumo(net: str, name: str) -> list[str]:
    """Return what SUMO itself finds wrong with a network when it loads it; empty if nothing."""
    with tempfile.TemporaryDirectory(prefix="plant-bench-") as folder:
        (Path(folder) / "town.net.xml").write_text(net, encoding="utf-8")
        options = ["-n", "town.net.xml", "--end", "2", "--no-step-log", "true", "--no-warnings"]
        run = _run("sumo", options, folder, name)
    return _lines(run.stderr) if run.returncode else []


def _run(
    program: str, options: list[str], folder: str, name: str
) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            [str(Path(sumo.SUMO_HOME) / "bin" / program), *options],
            cwd=folder,
            env={**os.environ, "SUMO_HOME": sumo.SUMO_HOME, "LC_ALL": "C"},
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            stdin=subprocess.DEVNULL,
            timeout=TIMEOUT_S,
            preexec_fn=_limit if sys.platform != "win32" else None,
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(
            f"{program} did not finish {name} in {TIMEOUT_S} s: cut out a smaller part of the map."
        ) from error


def _limit() -> None:
    import resource

    for what, most in (("RLIMIT_AS", MOST_MEMORY), ("RLIMIT_FSIZE", MOST_OUTPUT)):
        with contextlib.suppress(AttributeError, ValueError, OSError):
            resource.setrlimit(getattr(resource, what), (most, most))


def _lines(text: str) -> list[str]:
    """What a program of SUMO said, without what it always says, each line of a bearable length."""
    lines = (line.strip() for line in text.splitlines())
    said = (line for line in lines if line and line not in ("Success.", "Quitting (on error)."))
    return [line.removeprefix("Warning: ").removeprefix("Error: ")[:300] for line in said]
