"""Checks a town: edges reachable, no dead ends, paths drivable, requirements of the spec met."""

import networkx as nx

from plant_bench.towns.drivable import find_undrivable
from plant_bench.towns.town_spec import Requirements
from plant_bench.towns.town_summary import summarise
from plant_bench.world.town import Town


def find_faults(town: Town, requires: Requirements) -> list[str]:
    """Return a description of every fault of a town."""
    return [
        *find_missing(town, requires),
        *find_dead_lanes(town),
        *find_unreachable(town),
        *find_undrivable(town),
    ]


def find_missing(town: Town, requires: Requirements) -> list[str]:
    """Return the requirements of the spec that the town does not meet."""
    summary = summarise(town)
    unsignalled = ("priority", "stop", "allway", "right_before_left")
    have = {
        **vars(summary),
        "signalled": summary.signals,
        "unsignalled": sum(summary.junctions.get(kind, 0) for kind in unsignalled),
    }
    minimums = requires.model_dump()
    return [
        f"expected {count:g} or more {what}, got {have[what]:g}"
        for what, count in minimums.items()
        if have[what] < count
    ]


def find_dead_lanes(town: Town) -> list[str]:
    """Return lanes without predecessor or successor; acceleration lanes may end."""
    entered = {link.target for link in town.links}
    faults = []
    for edge, lanes in town.edges.items():
        for lane in lanes:
            merges = lane.acceleration and len(lanes) > 2 and lane in (lanes[0], lanes[-1])
            if lane.id not in town.links_from and not merges:
                faults.append(f"lane {lane.id} has no successor")
            widened = any(other.id in entered for other in lanes if other is not lane)
            if lane.id not in entered and not (widened and _is_exit_lane(town, edge, lane.index)):
                faults.append(f"lane {lane.id} has no predecessor")
    return faults


def _is_exit_lane(town: Town, edge: str, index: int) -> bool:
    """Return whether a lane is an outermost one and leads to other edges than its neighbours."""
    lanes = town.edges[edge]
    if index not in (lanes[0].index, lanes[-1].index):
        return False
    own = {_edge_of(link.target) for link in town.links_from.get(f"{edge}_{index}", ())}
    others = {
        _edge_of(link.target)
        for lane in lanes
        if lane.index != index
        for link in town.links_from.get(lane.id, ())
    }
    return bool(own) and not own & others


def _edge_of(lane: str) -> str:
    return lane.rsplit("_", 1)[0]


def find_unreachable(town: Town) -> list[str]:
    """Return the edges outside the largest strongly connected part of the road network."""
    graph = nx.DiGraph()
    graph.add_nodes_from(town.edges)
    graph.add_edges_from((_edge_of(link.source), _edge_of(link.target)) for link in town.links)
    parts = sorted(nx.strongly_connected_components(graph), key=len, reverse=True)
    return [f"edge {edge} is unreachable" for part in parts[1:] for edge in sorted(part)]
