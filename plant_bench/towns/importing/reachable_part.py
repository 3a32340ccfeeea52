"""Finds the roads of a town on which cars can circulate, on wide enough lanes."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import networkx as nx

from plant_bench.errors import InputError
from plant_bench.towns.importing.map_findings import Finding, repaired
from plant_bench.world.town import Lane, Town

MIN_LANE_WIDTH = 2.3  # m: the ego's 2.13 m and a margin on each side
MIN_TOWN_LENGTH = 300.0  # m of roads


def without_narrow_lanes(town: Town) -> tuple[Town, list[Finding]]:
    """Return a town without lanes too narrow for the ego, except lanes inside junctions."""
    narrow = {
        lane.id
        for lane in town.lanes.values()
        if lane.width < MIN_LANE_WIDTH and lane.junction is None
    }
    done = f"not used: narrower than {MIN_LANE_WIDTH} m"
    return without_lanes(town, narrow), repaired("narrow lanes", done, sorted(narrow))


def without_lanes(town: Town, left_out: set[str]) -> Town:
    """Return a town without the lanes in `left_out` and the links from and to them."""
    if not left_out:
        return town

    def kept(lane: Lane) -> Lane:
        return replace(
            lane,
            successors=tuple(item for item in lane.successors if item not in left_out),
            left=None if lane.left in left_out else lane.left,
            right=None if lane.right in left_out else lane.right,
        )

    removed = [link for link in town.links if {link.source, link.target} & left_out]
    left_out_lanes = left_out | {via for link in removed for via in link.via}
    return replace(
        town,
        lanes={name: kept(lane) for name, lane in town.lanes.items() if name not in left_out_lanes},
        links=tuple(link for link in town.links if not {link.source, link.target} & left_out),
    )


def unreachable_edges(town: Town, ends: Mapping[str, tuple[str, str]]) -> list[str]:
    """Return the edges that no vehicle can circulate on.

    Kept are the largest part in which every edge reaches every other, and further such parts that
    share a junction with it, such as the other direction of a ring road: routes need one part only,
    but oncoming traffic needs the others.

    Args:
        town: The town.
        ends: All edges of the network, each with the junctions at its start and end.
    """
    graph = nx.DiGraph()
    graph.add_nodes_from(town.edges)
    graph.add_edges_from(
        (town.lanes[link.source].edge, town.lanes[link.target].edge) for link in town.links
    )
    parts = sorted(sorted(part) for part in nx.strongly_connected_components(graph))
    parts = [part for part in parts if len(part) > 1 or graph.has_edge(part[0], part[0])]
    parts.sort(key=lambda part: -_metres(town, part))
    kept = set(parts[0]) if parts else set()
    waiting = parts[1:]
    junctions = {junction for edge in kept for junction in ends[edge]}
    while beside := [part for part in waiting if any({*ends[e]} & junctions for e in part)]:
        waiting = [part for part in waiting if part not in beside]
        kept |= {edge for part in beside for edge in part}
        junctions |= {junction for part in beside for edge in part for junction in ends[edge]}
    return sorted(set(ends) - kept)


def lane_metres(town: Town, edges: Iterable[str]) -> float:
    """Return the length of all lanes of some edges, metres."""
    return math.fsum(lane.length for edge in edges for lane in town.edges.get(edge, ()))


def _metres(town: Town, edges: list[str]) -> float:
    return round(sum((town.edges[edge][0].length for edge in edges), 0.0), 3)


def check_remaining(town: Town, removed: list[str], file: str) -> None:
    """Check that enough of a map is left without the edges in `removed`.

    Raises:
        InputError: Too little of `file` is left.
    """
    left = _metres(town, sorted(set(town.edges) - set(removed)))
    if left < MIN_TOWN_LENGTH:
        raise InputError(
            f"{file}: of {_metres(town, list(town.edges)):.0f} m of roads only {left:.0f} m are "
            f"part of a loop, expected at least {MIN_TOWN_LENGTH:.0f} m. Dead ends do not count, "
            "because cars cannot turn back there: use a map on which cars can drive in circles."
        )


def removal_findings(town: Town, removed: list[str], *, cut_off: bool = False) -> list[Finding]:
    """Return the findings of removing edges: dead ends, separate parts, and edges without cars.

    Args:
        town: The town, still with the edges.
        removed: The edges.
        cut_off: Whether they were connected to the town until a path or road that cannot be driven
            was removed.
    """
    onward = {town.lanes[link.source].edge for link in town.links}
    entered = {town.lanes[link.target].edge for link in town.links}
    driven = [edge for edge in removed if edge in town.edges]
    narrow = repaired(
        "edges too narrow for cars", "removed", sorted(set(removed) - set(town.edges))
    )
    if cut_off:
        done = "removed: a path or road that no car can follow was the only way in or back"
        return [
            *repaired("roads cut off by a removed path", done, driven, lane_metres(town, driven)),
            *narrow,
        ]
    ends = [edge for edge in driven if edge not in onward or edge not in entered]
    others = sorted(set(driven) - set(ends))
    return [
        *repaired(
            "dead ends", "removed: cars cannot turn back there", ends, lane_metres(town, ends)
        ),
        *repaired(
            "parts that cannot be entered or left", "removed", others, lane_metres(town, others)
        ),
        *narrow,
    ]
