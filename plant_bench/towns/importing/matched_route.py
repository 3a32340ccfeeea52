"""Builds a benchmark Route from the lanes that a CARLA route was matched to."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plant_bench.towns.importing.matching import UnmatchedError
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_lanes import (
    AFTER_JUNCTION,
    BEFORE_STOP_LINE,
    CHANGE_TIME,
    CHANGE_USUAL,
    ChangeSpan,
    LanePlan,
)
from plant_bench.towns.route_line import Drift, LaneStep, trace_steps
from plant_bench.towns.route_making import route_along
from plant_bench.world.route import Route
from plant_bench.world.town import Lane, Link, Town

LEAD = 6.0  # m of lane added to a route that starts or ends inside a junction
MIN_CHANGE_LENGTH = 10.0  # m of road that a lane change needs
MIN_ROUTE_LENGTH = 30.0  # m

Visit = tuple[str, list[float]]  # a lane, and the arc lengths of the points matched to it, metres


@dataclass
class _Edge:
    """One edge of the route with its lanes in order; mutable while the route is built."""

    visits: list[Visit]
    start: float = 0.0
    end: float | None = None
    before: float = 0.0  # m from the last matched point before the edge to its start
    after: float = 0.0  # m from the edge's end to the next matched point


def build_route(graph: StreetGraph, visits: Sequence[Visit], name: str) -> Route:
    """Build a route from the lanes that a CARLA route was matched to.

    Args:
        graph: The town's edges.
        visits: Lanes in order, each with the arc lengths of the points matched to it, metres.
        name: The route's id.

    Raises:
        UnmatchedError: A lane change does not fit, or the route is too short.
    """
    town = graph.town
    visits = _extended(town, list(visits))
    edges, links = _edges_and_links(town, visits)
    edges[0].start, edges[-1].end = visits[0][1][0], visits[-1][1][-1]
    steps: list[LaneStep] = []
    _measure_rooms(town, visits, edges)
    for index, edge in enumerate(edges):
        steps += _steps_on(town, edge)
        if index < len(links):
            steps += [LaneStep(town.lanes[via]) for via in links[index].via]
    plan = LanePlan(
        edges=tuple(town.lanes[edge.visits[0][0]].edge for edge in edges),
        entered=tuple(edge.visits[0][0] for edge in edges),
        left=tuple(edge.visits[-1][0] for edge in edges),
        links=tuple(links),
    )
    start, end = edges[0].start, edges[-1].end
    if len(edges) == 1 and end - start < MIN_ROUTE_LENGTH:
        raise UnmatchedError(0, f"the route is shorter than {MIN_ROUTE_LENGTH:.0f} m")
    return route_along(graph, plan, trace_steps(town, steps, start=start, end=end), name)


def _extended(town: Town, visits: list[Visit]) -> list[Visit]:
    """Return the visits, extended so that they start and end outside junctions."""
    while town.lanes[visits[0][0]].junction is not None:
        first = visits[0][0]
        lane = town.lanes[_before(town, first)]
        visits = [(lane.id, [max(0.0, lane.length - LEAD)]), *visits]
    while town.lanes[visits[-1][0]].junction is not None:
        lane = town.lanes[town.lanes[visits[-1][0]].successors[0]]
        visits = [*visits, (lane.id, [min(lane.length, LEAD)])]
    return visits


def _before(town: Town, lane: str) -> str:
    """Return the lane before a lane inside a junction."""
    for link in town.links:
        if lane in link.via:
            chain = (link.source, *link.via)
            return chain[chain.index(lane) - 1]
    raise UnmatchedError(0, f"nothing leads to {lane}")


def _edges_and_links(town: Town, visits: Sequence[Visit]) -> tuple[list[_Edge], list[Link]]:
    edges: list[_Edge] = []
    links: list[Link] = []
    inside: list[str] = []
    for visit in visits:
        lane = town.lanes[visit[0]]
        if lane.junction is not None:
            inside.append(lane.id)
            continue
        if edges and not inside and town.lanes[edges[-1].visits[-1][0]].edge == lane.edge:
            edges[-1].visits.append(visit)
            continue
        if edges:
            links.append(_link(town, edges[-1].visits[-1][0], lane.id, tuple(inside)))
        edges.append(_Edge([visit]))
        inside = []
    return edges, links


def _measure_rooms(town: Town, visits: Sequence[Visit], edges: Sequence[_Edge]) -> None:
    """Measure the road before and after each edge that has no matched points."""
    flat = [id(visit) for visit in visits]
    for edge in edges:
        first, last = flat.index(id(edge.visits[0])), flat.index(id(edge.visits[-1]))
        lane = town.lanes[edge.visits[0][0]]
        edge.after = _free_metres(town, visits[last + 1 :], lane.edge, forward=True)
        edge.before = _free_metres(town, visits[:first][::-1], lane.edge, forward=False)


def _free_metres(town: Town, visits: Sequence[Visit], edge: str, *, forward: bool) -> float:
    """Return the metres to the next matched point; lanes of one edge count once."""
    passed, current = 0.0, 0.0
    for name, anchors in visits:
        lane = town.lanes[name]
        if lane.edge != edge:
            passed, current = passed + current, lane.length
        edge = lane.edge
        if anchors:
            return passed + (anchors[0] if forward else lane.length - anchors[-1])
    return passed + current


def _link(town: Town, source: str, target: str, via: tuple[str, ...]) -> Link:
    links = [link for link in town.links_from.get(source, ()) if link.target == target]
    return next((link for link in links if link.via == via), links[0])


def _steps_on(town: Town, edge: _Edge) -> list[LaneStep]:
    """Return the steps on one edge: lanes, and lane changes between the matched positions."""
    steps: list[LaneStep] = []
    run: list[Visit] = [edge.visits[0]]
    for visit in edge.visits[1:]:
        run.append(visit)
        if visit[1]:
            steps += _changes(town, run, edge)
            run = [visit]
    if len(run) > 1:
        steps += _changes(town, run, edge)
    return [*steps, LaneStep(town.lanes[edge.visits[-1][0]])]


def _changes(town: Town, run: Sequence[Visit], edge: _Edge) -> list[LaneStep]:
    """Return the lane changes between two matched positions, or the ends of the edge.

    If the edge is too short for them, they go on after its end, through the junction, or begin
    before its start, as far as there is no other matched point.
    """
    lane, goal = town.lanes[run[0][0]], town.lanes[run[-1][0]]
    share = lane.length / goal.length
    low = run[0][1][-1] if run[0][1] else AFTER_JUNCTION
    high = run[-1][1][0] * share if run[-1][1] else lane.length - BEFORE_STOP_LINE
    low = max(low, edge.start)
    if high - low < (len(run) - 1) * MIN_CHANGE_LENGTH and not (run[0][1] and run[-1][1]):
        steps = _drifts(town, run, edge)
        if steps:
            return steps
    spans = _spans(lane, low, high, len(run) - 1, edge.start)
    return [
        LaneStep(town.lanes[before[0]], span, town.lanes[after[0]])
        for (before, after), span in zip(pairwise(run), spans, strict=True)
    ]


def _drifts(town: Town, run: Sequence[Visit], edge: _Edge) -> list[LaneStep]:
    """Return lane changes that reach beyond the edge; none if there is no room either."""
    lane, count = town.lanes[run[0][0]], len(run) - 1
    needed = count * max(CHANGE_USUAL, CHANGE_TIME * lane.speed_limit)
    is_early = bool(run[-1][1])
    if is_early:
        place = min(run[-1][1][0], lane.length)
        metres = min(needed, place + edge.before)
    else:
        place = max(run[0][1][-1] if run[0][1] else 0.5 * lane.length, edge.start)
        metres = min(needed, lane.length - place + edge.after)
    if metres < count * MIN_CHANGE_LENGTH:
        return []
    bounds = (
        np.linspace(-metres, 0.0, count + 1) if is_early else np.linspace(0.0, metres, count + 1)
    )
    return [
        LaneStep(
            town.lanes[before[0]],
            ChangeSpan(place, place),
            town.lanes[after[0]],
            Drift(float(begin), float(end)),
        )
        for (before, after), (begin, end) in zip(pairwise(run), pairwise(bounds), strict=True)
    ]


def _spans(lane: Lane, low: float, high: float, count: int, start: float) -> list[ChangeSpan]:
    """Return spans for lane changes between two arc lengths, or beyond them if space is short."""
    missing = count * MIN_CHANGE_LENGTH - (high - low)
    if missing > 0.0:
        low = max(start, low - 0.5 * missing)
        high = min(lane.length - 0.5, max(high, low + count * MIN_CHANGE_LENGTH))
        low = max(start, min(low, high - count * MIN_CHANGE_LENGTH))
    available = (high - low) / count
    if available < 0.5 * MIN_CHANGE_LENGTH:
        raise UnmatchedError(0, f"{lane.id} is too short for {count} lane changes")
    length = min(available, max(CHANGE_USUAL, CHANGE_TIME * lane.speed_limit))
    return [ChangeSpan(low + i * available, low + i * available + length) for i in range(count)]
