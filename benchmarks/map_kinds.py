"""Imports maps of many kinds: how much of what can be driven is kept, and does the expert finish?

    python benchmarks/map_kinds.py --out reports/map-kinds

Each map is made here, by hand or with SUMO's netgenerate and netconvert. Exit code 1 if less than
98 % of the mutually reachable car lanes of a map are kept.
"""

import argparse
import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import networkx as nx
import sumo

import plant_bench as pb
from plant_bench.errors import InputError
from plant_bench.scoring.results import Status
from plant_bench.towns.extract import extract_town
from plant_bench.towns.importing.map_conversion import convert_source
from plant_bench.towns.importing.map_source import read_source
from plant_bench.towns.importing.net_edits import turnarounds, without_connections
from plant_bench.towns.importing.suite_making import RouteRequest
from plant_bench.towns.importing.town_making import make_imported_town, save_imported_town
from plant_bench.world.town import Town

ENOUGH = 0.98
BIN = Path(sumo.SUMO_HOME) / "bin"
Maker = Callable[[Path], Path]


def run(program: str, *options: str) -> None:
    """Run one of SUMO's programs."""
    subprocess.run([str(BIN / program), *options], check=True, capture_output=True)


def generated(*options: str) -> Maker:
    """Return a maker of a network with netgenerate."""

    def make(folder: Path) -> Path:
        path = folder / "map.net.xml"
        run("netgenerate", *options, "--no-turnarounds.except-deadend", "-o", str(path))
        return path

    return make


def plain(nodes: str, edges: str, *options: str) -> Maker:
    """Return a maker of a network with netconvert from nodes and edges."""

    def make(folder: Path) -> Path:
        (folder / "n.nod.xml").write_text(f"<nodes>{nodes}</nodes>")
        (folder / "e.edg.xml").write_text(f"<edges>{edges}</edges>")
        path = folder / "map.net.xml"
        files = ["-n", str(folder / "n.nod.xml"), "-e", str(folder / "e.edg.xml"), "-o", str(path)]
        run("netconvert", *files, "--no-turnarounds", *options)
        return path

    return make


def both(a: str, b: str, lanes: int = 1, speed: float = 13.9, shape: str = "") -> str:
    """Return a two-way road between two nodes."""
    back = " ".join(reversed(shape.split()))
    return edge(a, b, lanes, speed, shape) + edge(b, a, lanes, speed, back)


def edge(a: str, b: str, lanes: int = 1, speed: float = 13.9, shape: str = "") -> str:
    """Return a one-way road between two nodes."""
    line = f' shape="{shape}"' if shape else ""
    name = f"{a}to{b}"
    return f'<edge id="{name}" from="{a}" to="{b}" numLanes="{lanes}" speed="{speed}"{line}/>'


def grid(size: int, step: float, lanes: int, *, stubs: bool, kind: str = "priority") -> tuple:
    """Return nodes and edges of a grid of two-way roads."""
    names = {(i, j): f"n{i}_{j}" for i in range(size) for j in range(size)}
    nodes = "".join(
        f'<node id="{name}" x="{i * step}" y="{j * step}" type="{kind}"/>'
        for (i, j), name in names.items()
    )
    edges = ""
    for (i, j), name in names.items():
        for other in ((i + 1, j), (i, j + 1)):
            if other in names:
                edges += both(name, names[other], lanes)
    if stubs:
        for k in range(size):
            for at, end in (((-0.4, k), (0, k)), ((size - 0.6, k), (size - 1, k))):
                name = f"s{end[0]}_{k}"
                nodes += f'<node id="{name}" x="{at[0] * step}" y="{at[1] * step}"/>'
                edges += both(name, names[end], lanes)
    return nodes, edges


def circle(radius: float, count: int, lanes: int, speed: float, *, two_way: bool) -> tuple:
    """Return nodes and edges of a ring road."""
    nodes, edges = "", ""
    for k in range(count):
        angle = 2 * math.pi * k / count
        x, y = radius * math.cos(angle), radius * math.sin(angle)
        nodes += f'<node id="c{k}" x="{x:.2f}" y="{y:.2f}"/>'
        points = [
            f"{radius * math.cos(a):.2f},{radius * math.sin(a):.2f}"
            for a in (angle + 2 * math.pi / count * s / 12 for s in range(13))
        ]
        road = both if two_way else edge
        edges += road(f"c{k}", f"c{(k + 1) % count}", lanes, speed, " ".join(points))
    return nodes, edges


def short_edges() -> tuple:
    """Return a square block whose corners are joined by edges of one to three metres."""
    corners = [(0, 0), (200, 0), (200, 200), (0, 200)]
    nodes, edges, last = "", "", ""
    names: list[str] = []
    for number, (x, y) in enumerate(corners):
        nx_, ny = corners[(number + 1) % 4]
        dx, dy = (nx_ - x) / 200, (ny - y) / 200
        for at in (12.0, 13.0, 15.5, 100.0, 101.5, 185.0, 188.0):
            name = f"p{number}_{at:.0f}_{len(names)}"
            nodes += f'<node id="{name}" x="{x + at * dx}" y="{y + at * dy}"/>'
            names.append(name)
    for number, name in enumerate(names):
        last = names[(number + 1) % len(names)]
        edges += both(name, last)
    return nodes, edges


def levels() -> tuple:
    """Return two loops that cross at the same height, without a junction."""
    first = circle(150.0, 4, 1, 13.9, two_way=True)
    nodes = "".join(
        f'<node id="q{k}" x="{x}" y="{y}"/>'
        for k, (x, y) in enumerate(((40, -300), (40, 300), (400, 300), (400, -300)))
    )
    edges = "".join(both(f"q{k}", f"q{(k + 1) % 4}") for k in range(4))
    link = both("q3", "c3") + both("q2", "c1")
    return first[0] + nodes, first[1] + edges + link


KINDS: dict[str, Maker] = {
    "grid 3, no stubs": plain(*grid(3, 150, 1, stubs=False)),
    "grid 3, stubs": plain(*grid(3, 150, 1, stubs=True)),
    "grid 4, two lanes, stubs": plain(*grid(4, 140, 2, stubs=True)),
    "grid 3, signals": plain(*grid(3, 160, 2, stubs=False, kind="traffic_light")),
    "grid 3, joined signals": plain(
        *grid(3, 160, 2, stubs=False, kind="traffic_light"), "--tls.join", "--tls.join-dist", "400"
    ),
    "grid 3, right before left": plain(*grid(3, 120, 1, stubs=True, kind="right_before_left")),
    "grid 5, narrow junctions": plain(
        *grid(5, 90, 1, stubs=False), "--default.junctions.radius", "1"
    ),
    "netgenerate grid": generated("--grid", "--grid.number", "4", "--grid.length", "150"),
    "netgenerate grid with stubs": generated(
        "--grid", "--grid.number", "3", "--grid.length", "150", "--grid.attach-length", "80"
    ),
    "netgenerate spider": generated("--spider", "--spider.arm-number", "6"),
    "netgenerate random 1": generated("--rand", "--rand.iterations", "60", "--seed", "1"),
    "netgenerate random 2": generated("--rand", "--rand.iterations", "80", "--seed", "2"),
    "netgenerate random 3, two lanes": generated(
        "--rand", "--rand.iterations", "60", "--seed", "3", "--default.lanenumber", "2"
    ),
    "ring, two-way": plain(*circle(120.0, 4, 1, 13.9, two_way=True)),
    "small ring, two-way": plain(*circle(60.0, 6, 1, 8.3, two_way=True)),
    "ring, one-way": plain(*circle(150.0, 5, 2, 13.9, two_way=False)),
    "motorway ring": plain(*circle(400.0, 8, 3, 33.3, two_way=True)),
    "square block": plain(*grid(2, 200, 1, stubs=False)),
    "short edges": plain(*short_edges()),
    "levels": plain(*levels()),
}


def reachable(town: Town) -> dict[str, float]:
    """Return the lane metres of each edge of the largest part that is mutually reachable."""
    graph = nx.DiGraph()
    graph.add_edges_from(
        (town.lanes[link.source].edge, town.lanes[link.target].edge) for link in town.links
    )
    metres = {name: sum(lane.length for lane in lanes) for name, lanes in town.edges.items()}
    parts = [part for part in nx.strongly_connected_components(graph) if len(part) > 1]
    best = max(parts, key=lambda part: sum(metres[name] for name in part), default=set())
    return {name: metres[name] for name in best}


def reachable_in_map(path: Path) -> dict[str, float]:
    """Return `reachable` of a map as netconvert reads it, without turnarounds."""
    raw = convert_source(read_source(path), guess_signals=False).net
    raw = without_connections(raw, turnarounds(raw))
    return reachable(extract_town(raw, "raw"))


def share_kept(before: dict[str, float], town: Town) -> float:
    """Return the share of the lane metres of `reachable_in_map` that a town still has."""
    kept = sum(metres for name, metres in before.items() if name in town.edges)
    return kept / max(sum(before.values()), 1e-9)


def main() -> int:
    """Import each kind, compare, drive, and print a table."""
    options = _options()
    worst = 1.0
    print(f"{'map':34} {'reachable':>9} {'kept':>7}  expert")
    for number, (kind, make) in enumerate(KINDS.items()):
        with tempfile.TemporaryDirectory() as scratch:
            path = make(Path(scratch))
            before = reachable_in_map(path)
            name = f"kind{number}"
            request = RouteRequest(count=2, shortest=200.0, longest=900.0)
            try:
                made = make_imported_town(
                    path, name, request, guess_signals=False, say=lambda _: None
                )
            except InputError as error:
                print(f"{kind:34} {error}")
                worst = 0.0
                continue
        share = share_kept(before, made.town)
        worst = min(worst, share)
        settings = {"file": kind, "seed": 0}
        suite = save_imported_town(made, options.out / name, settings, overwrite=True)
        said = "not driven"
        if options.drive:
            out = options.out / f"{name}-expert"
            run_ = pb.score("expert", suite=str(suite), repetitions=1, out=out, recordings=False)
            done = sum(result.status is Status.COMPLETED for result in run_.results)
            said = f"{done} of {len(run_.results)} completed, DS {run_.summary.driving_score:.0f}"
        total = sum(before.values()) / 1000.0
        print(f"{kind:34} {total:6.2f} km {100 * share:6.1f}%  {said}", flush=True)
    return 0 if worst >= ENOUGH else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("reports/map-kinds"))
    parser.add_argument("--no-drive", dest="drive", action="store_false", help="import only")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
