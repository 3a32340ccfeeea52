"""Mending a network: converted again and again until all that is left of it can be driven."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import networkx as nx

from plant_bench.errors import InputError
from plant_bench.towns.drivable import drive_all
from plant_bench.towns.extract import extract_town
from plant_bench.towns.importing.converting import Converted, convert_again, convert_source
from plant_bench.towns.importing.findings import Finding, merged, repaired, reported
from plant_bench.towns.importing.levels import lift_crossings
from plant_bench.towns.importing.net_edits import (
    Way,
    ends_of_edges,
    turnarounds,
    way_of_link,
    without_ways,
)
from plant_bench.towns.importing.source import MapSource
from plant_bench.world.town import Lane, Town

ROUNDS = 12  # conversions until nothing is left to mend
MOST_LANES = 20_000
NARROWEST = 2.3  # m: the ego's 2.13 and a hand's breadth on each side
WORST_GAP = 0.5  # m between the lanes of one way
WORST_ERROR = 0.8  # m that a car following the way leaves it by
TIGHTEST = 2.5  # m of radius: the ego turns in about 4 m, and a lane is wider than the ego
SHORTEST_TOWN = 300.0  # m of lanes

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Mended:
    """A network that can be driven, and what was done to make it so.

    Attributes:
        net: XML text.
        town: What was extracted from it; lanes too narrow to be driven are left out.
        findings: Repairs, and what netconvert said.
    """

    net: str
    town: Town
    findings: list[Finding]


def mend(source: MapSource, name: str, *, guess_signals: bool, say: Progress) -> Mended:
    """Make a network of a map and take from it what cannot be driven.

    Args:
        source: The map.
        name: The town's name.
        guess_signals: Whether netconvert puts signals where traffic seems to need them.
        say: Told what is being done.

    Raises:
        InputError: netconvert cannot use the map, or nothing of it is left that can be driven.
    """
    say(f"Converting {source.file}")
    converted = convert_source(source, guess_signals=guess_signals)
    findings = _of_the_file(source, converted)
    net = converted.net
    for number in range(1, ROUNDS + 1):
        say(f"Looking for what cannot be driven, round {number}")
        net, town, found = _round(net, source, name)
        findings += found
        if not found:
            return Mended(net, town, merged(findings))
    raise InputError(
        f"{source.file}: after {ROUNDS} rounds of repairs there is still something that cannot be "
        f"driven ({findings[-1].what}). Mend the map in netedit, or cut out another part."
    )


def _of_the_file(source: MapSource, converted: Converted) -> list[Finding]:
    findings = reported(
        "netconvert's warnings", "look at these places if a route goes there", converted.warnings
    )
    if not source.internal_lanes:
        done = "netconvert made them from the junctions' shapes"
        findings += repaired("no lanes inside junctions", done, ["the whole map"])
    if source.kind.value == "net" and not source.counts.get("connection"):
        done = "netconvert guessed them"
        findings += repaired("no connections between lanes", done, ["the whole map"])
    return findings


def _round(net: str, source: MapSource, name: str) -> tuple[str, Town, list[Finding]]:
    """Find what cannot be driven and convert without it; equal net and no findings at the end."""
    town = _extract(net, source, name)
    back = turnarounds(net)
    if back:
        return _again(without_ways(net, back), [], source), town, _turned(back)
    lifted, findings = lift_crossings(net, town, ends_of_edges(net))
    if findings:
        return _again(lifted, [], source), town, findings
    town, narrow = _without_narrow(town)
    bad, findings = _undrivable(town)
    if bad:
        return _again(without_ways(net, bad), [], source), town, findings
    cut_off = _cut_off(town, set(ends_of_edges(net)))
    if cut_off:
        if not _metres_left(town, cut_off) >= SHORTEST_TOWN:
            raise InputError(_nothing_left(source, town, cut_off))
        return _again(net, cut_off, source), town, [*narrow, *_dropped(town, cut_off)]
    return net, town, []


def _extract(net: str, source: MapSource, name: str) -> Town:
    town = extract_town(net, name)
    if not town.edges:
        raise InputError(
            f"{source.file} has no lane that a car may drive on. A map with roads is wanted."
        )
    if len(town.lanes) > MOST_LANES:
        raise InputError(
            f"{source.file} has {len(town.lanes)} lanes, {MOST_LANES} at most can be used: cut out "
            "a part of a few kilometres."
        )
    return town


def _again(net: str, removed: list[str], source: MapSource) -> str:
    return convert_again(net, removed, source.file).net


def _turned(ways: list[Way]) -> list[Finding]:
    done = "removed: no car turns on the spot"
    return repaired("turnarounds", done, [f"{before} to {after}" for before, after in ways])


def _without_narrow(town: Town) -> tuple[Town, list[Finding]]:
    """The town without lanes that the ego does not fit on, unless they are inside junctions."""
    narrow = {
        lane.id
        for lane in town.lanes.values()
        if lane.width < NARROWEST and lane.junction is None
    }
    done = f"not driven: narrower than {NARROWEST} m"
    return without_lanes(town, narrow), repaired("narrow lanes", done, sorted(narrow))


def without_lanes(town: Town, left_out: set[str]) -> Town:
    """Return a town without some lanes and all links from and to them."""
    if not left_out:
        return town

    def kept(lane: Lane) -> Lane:
        return replace(
            lane,
            successors=tuple(item for item in lane.successors if item not in left_out),
            left=None if lane.left in left_out else lane.left,
            right=None if lane.right in left_out else lane.right,
        )

    gone = left_out | {
        via
        for link in town.links
        if {link.source, link.target} & left_out
        for via in link.via
    }
    left_out |= gone
    return replace(
        town,
        lanes={name: kept(lane) for name, lane in town.lanes.items() if name not in gone},
        links=tuple(link for link in town.links if not {link.source, link.target} & left_out),
    )


def _undrivable(town: Town) -> tuple[list[Way], list[Finding]]:
    """The ways through junctions that no car can follow."""
    links = {f"{link.source}->{link.target}": link for link in town.links}
    gaps, tight = [], []
    for drive in drive_all(town):
        link = links.get(drive.path)
        if link is not None and drive.gap > WORST_GAP:
            gaps.append(link)
        elif link is not None and (drive.error > WORST_ERROR or drive.radius < TIGHTEST):
            tight.append(link)
    found = repaired(
        "disconnected lanes",
        f"the way between them removed: a gap of more than {WORST_GAP} m",
        [f"{link.source} to {link.target}" for link in gaps],
    )
    found += repaired(
        "ways too tight to drive",
        f"removed: a car leaves them by more than {WORST_ERROR} m, or they bend within "
        f"{TIGHTEST} m",
        [f"{link.source} to {link.target}" for link in tight],
    )
    return [way_of_link(link) for link in (*gaps, *tight)], found


def _cut_off(town: Town, edges: set[str]) -> list[str]:
    """The edges that are not of the largest part of which every edge reaches every other."""
    graph = nx.DiGraph()
    graph.add_nodes_from(town.edges)
    graph.add_edges_from(
        (town.lanes[link.source].edge, town.lanes[link.target].edge) for link in town.links
    )
    parts = sorted(map(sorted, nx.strongly_connected_components(graph)))
    best = max(parts, key=lambda part: _metres(town, part), default=[])
    return sorted(edges - set(best))


def _metres(town: Town, edges: list[str]) -> float:
    return round(sum(town.edges[edge][0].length for edge in edges), 3)


def _metres_left(town: Town, cut_off: list[str]) -> float:
    return _metres(town, [edge for edge in town.edges if edge not in set(cut_off)])


def _nothing_left(source: MapSource, town: Town, cut_off: list[str]) -> str:
    return (
        f"{source.file}: of {_metres(town, list(town.edges)):.0f} m of roads only "
        f"{_metres_left(town, cut_off):.0f} m can be reached from one another, "
        f"{SHORTEST_TOWN:.0f} m are wanted. Roads that end nowhere do not count, since cars cannot "
        "turn back there: take a map with a loop of roads."
    )


def _dropped(town: Town, cut_off: list[str]) -> list[Finding]:
    """Dead ends are told apart from parts that lead nowhere else, and from what carries no cars."""
    onward = {town.lanes[link.source].edge for link in town.links}
    entered = {town.lanes[link.target].edge for link in town.links}
    driven = [edge for edge in cut_off if edge in town.edges]
    ends = [edge for edge in driven if edge not in onward or edge not in entered]
    return [
        *repaired("dead ends", "removed: cars cannot turn back there", ends),
        *repaired(
            "parts without a way in or back", "removed", sorted(set(driven) - set(ends))
        ),
        *repaired(
            "edges too narrow for cars", "removed", sorted(set(cut_off) - set(town.edges))
        ),
    ]
