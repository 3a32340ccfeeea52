"""Fuzzing of imported maps and route files: valid files and their readers."""

import functools
import gzip
import os
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import sumo

from fuzzing.form import Format
from plant_bench.errors import InputError
from plant_bench.reports.tables import print_rows
from plant_bench.towns.importing import suite_making
from plant_bench.towns.importing.import_report import HEADS, finding_rows
from plant_bench.towns.importing.suite_making import RouteRequest
from plant_bench.towns.importing.town_making import (
    ImportedTown,
    make_imported_town,
    save_imported_town,
)
from plant_bench.world.route import load_suite
from plant_bench.world.town import load_town

PROGRAMS = frozenset({"netconvert", "sumo"})
LONGEST = 60.0  # s: netconvert and SUMO are begun several times a case
WANTED = RouteRequest(count=1, shortest=100.0, longest=300.0)
SIDE = 90  # m between junctions


def _netconvert(folder: Path, *options: str) -> None:
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    subprocess.run(
        [program, *options],
        cwd=folder,
        env={**os.environ, "SUMO_HOME": sumo.SUMO_HOME},
        check=True,
        capture_output=True,
    )


@functools.cache
def _files() -> dict[str, bytes]:
    """Return a ring road with a street across it as SUMO networks and as OpenDRIVE."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        nodes = '<node id="a" x="0" y="0" type="traffic_light"/><node id="b" x="0" y="160"/>'
        (folder / "n.xml").write_text(f"<nodes>{nodes}</nodes>", encoding="utf-8")
        (folder / "e.xml").write_text(_edges(), encoding="utf-8")
        more = ("--crossings.guess", "true", "--sidewalks.guess", "true")
        _netconvert(folder, "-n", "n.xml", "-e", "e.xml", "-o", "map.net.xml")
        _netconvert(folder, "-n", "n.xml", "-e", "e.xml", *more, "-o", "more.net.xml")
        _netconvert(folder, "-s", "map.net.xml", "--opendrive-output", "map.xodr")
        return {path.name: path.read_bytes() for path in folder.iterdir()}


def _edges() -> str:
    turns = np.linspace(0.0, np.pi, 9)
    half = [(80.0 * np.sin(turn), 80.0 - 80.0 * np.cos(turn)) for turn in turns]
    lines = {"east": half, "west": [(-x, y) for x, y in half], "middle": [half[0], half[-1]]}
    edges = ""
    for name, line in lines.items():
        for prefix, points, ends in (("up", line, ("a", "b")), ("down", line[::-1], ("b", "a"))):
            shape = " ".join(f"{x:.2f},{y:.2f}" for x, y in points)
            edges += f'<edge id="{prefix}{name}" from="{ends[0]}" to="{ends[1]}" numLanes="1" '
            edges += f'speed="13.9" shape="{shape}"/>'
    return f"<edges>{edges}</edges>"


def _ring() -> bytes:
    """Return a ring road of four arcs in OpenDRIVE, a lane each way."""
    parts = "".join(_arc(number) for number in range(4))
    return f'<OpenDRIVE><header revMajor="1" revMinor="4"/>{parts}</OpenDRIVE>'.encode()


def _arc(number: int) -> str:
    start, length, name = number * np.pi / 2, 25.0 * np.pi, number + 1
    x, y = 50.0 * np.cos(start), 50.0 * np.sin(start)
    lane = '<lane id="{0}" type="driving"><link><predecessor id="{0}"/><successor id="{0}"/></link>'
    lane += '<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
    before, after = (number + 3) % 4 + 1, (number + 1) % 4 + 1
    return (
        f'<road id="{name}" length="{length}" junction="-1"><link>'
        f'<predecessor elementType="road" elementId="{before}" contactPoint="end"/>'
        f'<successor elementType="road" elementId="{after}" contactPoint="start"/></link>'
        f'<planView><geometry s="0" x="{x}" y="{y}" hdg="{start + np.pi / 2}" length="{length}">'
        '<arc curvature="0.02"/></geometry></planView><elevationProfile>'
        '<elevation s="0" a="0" b="0" c="0" d="0"/></elevationProfile><lanes><laneSection s="0">'
        f'<left>{lane.format(1)}</left><center><lane id="0" type="none"/></center>'
        f"<right>{lane.format(-1)}</right></laneSection></lanes><signals>"
        f'<signal id="{name}" s="3" t="2" dynamic="yes" type="1000001" orientation="+"/></signals>'
        "</road>"
    )


def _streets() -> bytes:
    """Return six junctions in OpenStreetMap's form, with a tunnel, a path and a turn forbidden."""
    places = {1 + i + 3 * j: (i * SIDE, j * SIDE) for i in range(3) for j in range(2)}
    places |= {11: (SIDE, -70), 12: (SIDE, 160)}
    ways = [(a, a + 1) for a in (1, 2, 4, 5)] + [(a, a + 3) for a in (1, 3)]
    tagged = [(way, {"highway": "residential", "maxspeed": "50"}) for way in ways]
    tagged += [
        ((1, 11, 3), {"highway": "secondary", "lanes": "2", "oneway": "yes"}),
        ((4, 12, 6), {"highway": "tertiary", "tunnel": "yes", "layer": "-1"}),
        ((2, 5), {"highway": "primary", "lanes": "4", "turn:lanes:forward": "left|through"}),
        ((1, 6), {"highway": "footway"}),
    ]
    nodes = "".join(
        f'<node id="{n}" lat="{49 + y / 111320:.7f}" lon="{8 + x / 73032:.7f}">'
        f"{'<tag k=%(k)s v=%(v)s/>' % _SIGNAL if n == 2 else ''}</node>"  # noqa: UP031
        for n, (x, y) in places.items()
    )
    lines = "".join(_way(1000 + number, *way) for number, way in enumerate(tagged))
    return f'<osm version="0.6">{nodes}{lines}{_FORBIDDEN}</osm>'.encode()


_SIGNAL = {"k": '"highway"', "v": '"traffic_signals"'}
_FORBIDDEN = (
    '<relation id="9"><member type="way" ref="1000" role="from"/>'
    '<member type="node" ref="2" role="via"/><member type="way" ref="1008" role="to"/>'
    '<tag k="type" v="restriction"/><tag k="restriction" v="no_left_turn"/></relation>'
)


def _way(number: int, ends: tuple[int, ...], tags: dict[str, str]) -> str:
    inside = "".join(f'<nd ref="{n}"/>' for n in ends)  # codespell:ignore nd
    inside += "".join(f'<tag k="{k}" v="{v}"/>' for k, v in tags.items())
    return f'<way id="{number}">{inside}</way>'


@functools.cache
def imported_town() -> ImportedTown:
    """Return the town that is made of the first map."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "map.net.xml"
        path.write_bytes(_files()["map.net.xml"])
        return _make(path)


def net_seeds() -> list[bytes]:
    """Return SUMO networks: one that needs no mending, one that does."""
    return [imported_town().net.encode(), _files()["more.net.xml"]]


def _xodr_seeds() -> list[bytes]:
    return [_ring(), _files()["map.xodr"], gzip.compress(_ring(), 1)]


def _osm_seeds() -> list[bytes]:
    return [_streets(), gzip.compress(_streets(), 1)]


def _use_map(box: Path, name: str) -> None:
    """Import a map and save the town, as the command does; what was saved must load."""
    made = _make(box / name)
    about = {"file": name, "seed": 0, "guess_signals": False}
    suite = save_imported_town(made, box / "out", about, overwrite=True)
    print_rows("Town", list(HEADS), finding_rows(made.findings))
    check_suite(suite, box / "out" / "towns")


def check_suite(suite: Path, towns: Path) -> None:
    """Check that what an import has written can be used."""
    try:
        town = load_town("fuzzed", [towns])
        for route in load_suite(str(suite)):
            route.check_town(town)
    except InputError as error:
        raise AssertionError(str(error)) from error


def _make(path: Path) -> ImportedTown:
    suite_making.DRAWS = 80  # of the many draws no other code is run
    return make_imported_town(path, "fuzzed", WANTED, guess_signals=False, say=lambda _: None)


def _map_format(name: str, file: str, seeds: Callable[[], list[bytes]]) -> Format:
    return Format(
        name, "xml", file, seeds, partial(_use_map, name=file), programs=PROGRAMS,
        longest=LONGEST,
    )  # fmt: skip


FORMATS = (
    _map_format("net", "map.net.xml", net_seeds),
    _map_format("xodr", "map.xodr", _xodr_seeds),
    _map_format("osm", "map.osm", _osm_seeds),
)
