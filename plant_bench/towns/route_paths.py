"""Draws random edge paths through a town, via a few intermediate stops."""

import heapq
from collections.abc import Callable

import numpy as np

from plant_bench.towns.route_graph import StreetGraph

STOPS = (1, 5)  # intermediate stops between start and destination
DETOUR_SPREAD = 0.6  # standard deviation of the logarithm of an edge's random weight
REVISIT_FACTOR = 3.0  # cost factor of edges to a junction that the path has already passed
LANDMARK_SHARE = 0.5  # share of paths via an edge of `StreetGraph.landmarks`


def random_path(graph: StreetGraph, rng: np.random.Generator) -> tuple[str, ...] | None:
    """Draw a path of edges via a few random stops, without repeated edges.

    Returns:
        The path; None if the drawn stops cannot be connected.
    """
    edges = list(graph.town.edges)
    starts, ends = graph.starts, graph.ends
    stops = [edges[i] for i in rng.integers(len(edges), size=rng.integers(*STOPS, endpoint=True))]
    if graph.landmarks and rng.random() < LANDMARK_SHARE:
        stops[int(rng.integers(len(stops)))] = graph.landmarks[
            int(rng.integers(len(graph.landmarks)))
        ]
    spread = np.exp(DETOUR_SPREAD * rng.standard_normal(len(edges)))
    costs = {edge: graph.lengths[edge] * float(w) for edge, w in zip(edges, spread, strict=True)}
    path = [starts[int(rng.integers(len(starts)))]]
    for stop in (*stops, ends[int(rng.integers(len(ends)))]):
        if stop in path:
            continue
        leg = _leg(graph, path, stop, costs)
        if leg is None:
            return None
        path += leg
    return tuple(path)


def _leg(
    graph: StreetGraph, path: list[str], goal: str, costs: dict[str, float]
) -> list[str] | None:
    used, passed = set(path), {graph.junctions[edge] for edge in path[:-1]}

    def cost(edge: str) -> float:
        return costs[edge] * (REVISIT_FACTOR if graph.junctions.get(edge) in passed else 1.0)

    return _cheapest(graph, path[-1], goal, lambda edge: None if edge in used else cost(edge))


def _cheapest(
    graph: StreetGraph, start: str, goal: str, cost: Callable[[str], float | None]
) -> list[str] | None:
    """Return the cheapest path by Dijkstra, without `start`; edges of cost None are closed."""
    best, before, queue = {start: 0.0}, {}, [(0.0, start)]
    while queue:
        so_far, edge = heapq.heappop(queue)
        if edge == goal:
            path = [edge]
            while before[path[-1]] != start:
                path.append(before[path[-1]])
            return path[::-1]
        if so_far > best[edge]:
            continue
        for onward in graph.onward[edge]:
            more = cost(onward)
            if more is not None and so_far + more < best.get(onward, np.inf):
                best[onward], before[onward] = so_far + more, edge
                heapq.heappush(queue, (so_far + more, onward))
    return None
