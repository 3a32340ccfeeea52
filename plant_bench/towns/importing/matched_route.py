"""From the lanes of a matched route to a Route of the benchmark."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

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
from plant_bench.towns.route_line import LaneStep, trace_steps
from plant_bench.towns.route_making import route_along
from plant_bench.world.route import Route
from plant_bench.world.town import Lane, Link, Town

OUTSIDE = 6.0  # m of lane before and after a route that starts or ends inside a junction
CHANGE_SHORTEST = 10.0  # m of road that a lane change needs
SHORTEST = 30.0  # m of route

Visit = tuple[str, list[float]]


@dataclass
class _Edge:
    """One edge that is driven: its lanes in order; mutable while it is put together."""

    visits: list[Visit]
    start: float = 0.0
    end: float | None = None


def build_route(graph: StreetGraph, visits: Sequence[Visit], name: str) -> Route:
    """Make a route of the lanes that a matched one takes.

    Args:
        graph: The town's edges.
        visits: The lanes in order, each with the places where points were matched to it, metres.
        name: The route's id.

    Raises:
        UnmatchedError: There is no room for a lane change, or hardly any route.
    """
    town = graph.town
    visits = _from_outside(town, list(visits))
    edges, links = _edges_and_links(town, visits)
    edges[0].start, edges[-1].end = visits[0][1][0], visits[-1][1][-1]
    steps: list[LaneStep] = []
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
    if len(edges) == 1 and end - start < SHORTEST:
        raise UnmatchedError(0, f"the route has less than {SHORTEST:.0f} m")
    return route_along(graph, plan, trace_steps(town, steps, start=start, end=end), name)


def _from_outside(town: Town, visits: list[Visit]) -> list[Visit]:
    """The visits, begun and ended outside junctions."""
    while town.lanes[visits[0][0]].junction is not None:
        first = visits[0][0]
        lane = town.lanes[_before(town, first)]
        visits = [(lane.id, [max(0.0, lane.length - OUTSIDE)]), *visits]
    while town.lanes[visits[-1][0]].junction is not None:
        lane = town.lanes[town.lanes[visits[-1][0]].successors[0]]
        visits = [*visits, (lane.id, [min(lane.length, OUTSIDE)])]
    return visits


def _before(town: Town, lane: str) -> str:
    """The lane that a lane inside a junction is entered from."""
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


def _link(town: Town, source: str, target: str, via: tuple[str, ...]) -> Link:
    links = [link for link in town.links_from.get(source, ()) if link.target == target]
    return next((link for link in links if link.via == via), links[0])


def _steps_on(town: Town, edge: _Edge) -> list[LaneStep]:
    """The steps on one edge: its lanes, with lane changes between the places matched on them."""
    steps: list[LaneStep] = []
    run: list[Visit] = [edge.visits[0]]
    for visit in edge.visits[1:]:
        run.append(visit)
        if visit[1]:
            steps += _changes(town, run, edge.start)
            run = [visit]
    if len(run) > 1:
        steps += _changes(town, run, edge.start)
    return [*steps, LaneStep(town.lanes[edge.visits[-1][0]])]


def _changes(town: Town, run: Sequence[Visit], start: float) -> list[LaneStep]:
    """The lane changes between two matched places, or from the edge's begin or to its end."""
    lane, goal = town.lanes[run[0][0]], town.lanes[run[-1][0]]
    share = lane.length / goal.length
    low = run[0][1][-1] if run[0][1] else AFTER_JUNCTION
    high = run[-1][1][0] * share if run[-1][1] else lane.length - BEFORE_STOP_LINE
    spans = _spans(lane, max(low, start), high, len(run) - 1, start)
    return [
        LaneStep(town.lanes[before[0]], span, town.lanes[after[0]])
        for (before, after), span in zip(pairwise(run), spans, strict=True)
    ]


def _spans(lane: Lane, low: float, high: float, count: int, start: float) -> list[ChangeSpan]:
    """Places for lane changes between two arc lengths, or beyond them where there is no room."""
    missing = count * CHANGE_SHORTEST - (high - low)
    if missing > 0.0:
        low = max(start, low - 0.5 * missing)
        high = min(lane.length - 0.5, max(high, low + count * CHANGE_SHORTEST))
        low = max(start, min(low, high - count * CHANGE_SHORTEST))
    room = (high - low) / count
    if room < 0.5 * CHANGE_SHORTEST:
        raise UnmatchedError(0, f"no room for {count} lane changes on {lane.id}")
    length = min(room, max(CHANGE_USUAL, CHANGE_TIME * lane.speed_limit))
    return [ChangeSpan(low + i * room, low + i * room + length) for i in range(count)]
