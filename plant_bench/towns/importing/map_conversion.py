"""Runs netconvert on untrusted map files, with limits on time, memory and output size."""

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
from plant_bench.towns.importing.net_edits import with_net_offset_moved
from plant_bench.towns.netconvert import without_header

TIMEOUT_S = 300
MAX_MEMORY = 4 * 2**30  # bytes
MAX_OUTPUT = 2**30
LAYER_HEIGHT = 5.0  # m between the layers of an OpenStreetMap file
OUT_OF_MEMORY = "std::bad_alloc"
DANGLING = "is not known"  # in netconvert's messages about references
NO_ROADS = ("No nodes loaded", "No edges loaded")  # netconvert's messages for a map without roads

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
    """Result of a conversion.

    Attributes:
        net: The SUMO network, XML text.
        warnings: Lines that netconvert printed to stderr.
        workarounds: What had to be done differently for netconvert to succeed; each problem with
            what was done about it.
    """

    net: str
    warnings: tuple[str, ...]
    workarounds: tuple[tuple[str, str], ...] = ()


def convert_source(source: MapSource, *, guess_signals: bool) -> Converted:
    """Convert a map file to a SUMO network.

    Raises:
        InputError: netconvert fails, or exceeds the limits.
    """
    options = _OF_KIND[source.kind] | {_INPUTS[source.kind]: "map.xml"}
    if guess_signals:
        options["--tls.guess"] = "true"
    done: list[tuple[str, str]] = []
    while True:
        try:
            converted = _convert(source.content, options, (), source.file)
        except _NetconvertError as error:
            workaround = _workaround(error, options)
            if workaround is None:
                raise
            option, value, problem, remedy = workaround
            options[option] = value
            done.append((problem, remedy))
            continue
        net = with_net_offset_moved(converted.net, source.header_offset)
        return Converted(net, converted.warnings, tuple(done))


def _workaround(
    error: "_NetconvertError", options: dict[str, str]
) -> tuple[str, str, str, str] | None:
    """Return an option, its value, the problem and the remedy to try next; None if none is left."""
    internal = "--opendrive.internal-shapes"
    if error.crashed and options.get(internal) == "true":
        problem = "shapes of lanes inside junctions that crash netconvert"
        return internal, "false", problem, "left out: netconvert draws its own"
    dangling = not error.crashed and any(DANGLING in line for line in error.lines)
    if dangling and "--ignore-errors" not in options:
        problem = "references to roads or lanes that do not exist"
        return "--ignore-errors", "true", problem, f"ignored: {error.lines[0]}"
    return None


class _NetconvertError(InputError):
    """netconvert cannot convert a map.

    Attributes:
        lines: The lines that it printed, errors first.
        crashed: Whether it was ended by a signal.
    """

    def __init__(self, message: str, lines: Sequence[str], *, crashed: bool) -> None:
        super().__init__(message)
        self.lines = tuple(lines)
        self.crashed = crashed


def convert_again(net: str, removed: Sequence[str], name: str) -> Converted:
    """Convert a SUMO network (XML text) again, without the edges in `removed`.

    Raises:
        InputError: netconvert fails, or exceeds the limits.
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
            if any(line.startswith(NO_ROADS) for line in lines):
                raise InputError(f"{name} has no road that cars may drive on: use another map.")
            if OUT_OF_MEMORY in run.stderr:
                raise InputError(
                    f"netconvert needs more than {MAX_MEMORY / 2**30:.0f} GB for {name}: cut "
                    "out a smaller part of the map."
                )
            errors = _lines(run.stderr, errors_first=True)
            crashed = run.returncode < 0
            how = (
                f"netconvert crashed on {name}" if crashed else f"netconvert cannot convert {name}"
            )
            reason = "; ".join(errors[:2]) or f"exit code {run.returncode}"
            message = f"{how}: {reason}. Repair the map in its editor, or in netedit."
            raise _NetconvertError(message, errors, crashed=crashed)
        return Converted(without_header(out.read_text(encoding="utf-8")), tuple(lines))


def sumo_errors(net: str, name: str) -> list[str]:
    """Return the errors that SUMO reports when it loads a network; empty if there are none."""
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

    for resource_name, limit in (("RLIMIT_AS", MAX_MEMORY), ("RLIMIT_FSIZE", MAX_OUTPUT)):
        with contextlib.suppress(AttributeError, ValueError, OSError):
            resource.setrlimit(getattr(resource, resource_name), (limit, limit))


def _lines(text: str, *, errors_first: bool = False) -> list[str]:
    """Return the different lines that a SUMO program printed, without boilerplate, shortened."""
    lines = (line.strip() for line in text.splitlines())
    messages = [x for x in lines if x and x not in ("Success.", "Quitting (on error).")]
    if errors_first:
        messages.sort(key=lambda line: not line.startswith("Error: "))
    short = (line.removeprefix("Warning: ").removeprefix("Error: ")[:300] for line in messages)
    return list(dict.fromkeys(short))
