"""The part of a town in which every road reaches every other, on lanes that a car fits on."""

from dataclasses import replace

import networkx as nx

from plant_bench.errors import InputError
from plant_bench.towns.importing.map_findings import Finding, repaired
from plant_bench.world.town import Lane, Town

NARROWEST = 2.3  # m: the ego's 2.13 and a hand's breadth on each side
SHORTEST_TOWN = 300.0  # m of lanes


def without_narrow_lanes(town: Town) -> tuple[Town, list[Finding]]:
    """Return a town without lanes that the ego does not fit on, unless they are in junctions."""
    narrow = {
        lane.id for lane in town.lanes.values() if lane.width < NARROWEST and lane.junction is None
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

    doomed = [link for link in town.links if {link.source, link.target} & left_out]
    gone = left_out | {via for link in doomed for via in link.via}
    return replace(
        town,
        lanes={name: kept(lane) for name, lane in town.lanes.items() if name not in gone},
        links=tuple(link for link in town.links if not {link.source, link.target} & left_out),
    )


def edges_cut_off(town: Town, edges: set[str]) -> list[str]:
    """Return those edges that are not of the largest part where every edge reaches every other."""
    graph = nx.DiGraph()
    graph.add_nodes_from(town.edges)
    graph.add_edges_from(
        (town.lanes[link.source].edge, town.lanes[link.target].edge) for link in town.links
    )
    parts = sorted(sorted(part) for part in nx.strongly_connected_components(graph))
    parts = [part for part in parts if len(part) > 1 or graph.has_edge(part[0], part[0])]
    best = max(parts, key=lambda part: _metres(town, part), default=[])
    return sorted(edges - set(best))


def _metres(town: Town, edges: list[str]) -> float:
    return round(sum((town.edges[edge][0].length for edge in edges), 0.0), 3)


def check_what_is_left(town: Town, cut_off: list[str], file: str) -> None:
    """Check that enough of a map is left once some edges are cut off.

    Raises:
        InputError: Nothing of `file` that could be called a town.
    """
    left = _metres(town, sorted(set(town.edges) - set(cut_off)))
    if left < SHORTEST_TOWN:
        raise InputError(
            f"{file}: of {_metres(town, list(town.edges)):.0f} m of roads only {left:.0f} m can be "
            f"reached from one another, {SHORTEST_TOWN:.0f} m are wanted. Roads that end nowhere "
            "do not count, since cars cannot turn back there: take a map with a loop of roads."
        )


def findings_of(town: Town, cut_off: list[str]) -> list[Finding]:
    """Return what is cut off: dead ends, parts that lead nowhere else, what carries no cars."""
    onward = {town.lanes[link.source].edge for link in town.links}
    entered = {town.lanes[link.target].edge for link in town.links}
    driven = [edge for edge in cut_off if edge in town.edges]
    ends = [edge for edge in driven if edge not in onward or edge not in entered]
    return [
        *repaired("dead ends", "removed: cars cannot turn back there", ends),
        *repaired("parts without a way in or back", "removed", sorted(set(driven) - set(ends))),
        *repaired("edges too narrow for cars", "removed", sorted(set(cut_off) - set(town.edges))),
    ]
