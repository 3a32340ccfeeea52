"""Plans the lanes and the lane changes of a path of edges."""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from plant_bench.towns.route_graph import StreetGraph
from plant_bench.world.town import Lane, Link, Town

CHANGE_TIME = 3.0  # s: usual duration of a lane change
CHANGE_USUAL = 25.0  # m: usual minimum length of a lane change
CHANGE_LEAST = 20.0  # m: minimum length if space is short
CHANGE_GAP = 5.0  # m between two lane changes
AFTER_JUNCTION = 8.0  # m from a junction to the first lane change
BEFORE_STOP_LINE = 15.0  # m from the last lane change to the stop line
AFTER_LANE_BEGIN = 20.0  # m on an acceleration lane before the lane change
LONG_EDGE = 200.0  # m: on longer edges, lane changes keep clear of queues
QUEUE_ZONE = 60.0  # m before the stop line without lane changes on long edges
LATER_SHARE = 0.25  # share of a long edge's spare length that comes before its lane changes
KEEP_RIGHT = 0.01  # cost of driving one lane farther left, in lane changes


@dataclass(frozen=True)
class LanePlan:
    """The lanes of a path of edges.

    Attributes:
        edges: The path.
        entered: The lane on which each edge is entered; for the first edge, the lane of the start.
        left: The lane from which each edge is left; for the last edge, the lane of the end.
        links: The links between successive edges, one fewer than edges.
    """

    edges: tuple[str, ...]
    entered: tuple[str, ...]
    left: tuple[str, ...]
    links: tuple[Link, ...]


class ChangeSpan(NamedTuple):
    """The stretch of a lane on which a lane change takes place; arc lengths, metres."""

    start: float
    end: float


class _Way(NamedTuple):
    cost: float
    entered: tuple[str, ...]
    left: tuple[str, ...]
    links: tuple[Link, ...]


def plan_lanes(graph: StreetGraph, edges: tuple[str, ...]) -> LanePlan | None:
    """Choose lanes with the fewest lane changes; among equal plans, the one farthest to the right.

    The route may start on any lane of its first edge. There are no lane changes on its first and
    last edges.

    Returns:
        The plan; None if an edge is too short for its lane changes.
    """
    town = graph.town
    ways = {lane.id: _Way(0.0, (lane.id,), (), ()) for lane in town.edges[edges[0]]}
    for index, (edge, onward) in enumerate(pairwise(edges)):
        found: dict[str, _Way] = {}
        for link in graph.links(edge, onward):
            for entered, way in ways.items():
                changes = lanes_between(town, entered, link.source)
                if (changes and index == 0) or not _fits(town.lanes[entered], changes):
                    continue
                better = _onward(town, way, link, abs(changes))
                if link.target not in found or better.cost < found[link.target].cost - 1e-9:
                    found[link.target] = better
        ways = found
    ends = [way for lane, way in ways.items() if not town.lanes[lane].acceleration]
    if not ends:
        return None
    best = min(ends, key=lambda way: (round(way.cost, 6), way.entered))
    return LanePlan(edges, best.entered, (*best.left, best.entered[-1]), best.links)


def lanes_between(town: Town, lane: str, other: str) -> int:
    """Return the number of lanes from a lane to another of its edge, positive to the left."""
    ids = [item.id for item in town.edges[town.lanes[lane].edge]]
    return ids.index(other) - ids.index(lane)


def change_spans(lane: Lane, count: int) -> list[ChangeSpan] | None:
    """Place successive lane changes on an edge.

    Args:
        lane: The lane from which the first one starts.
        count: Number of lane changes.

    Returns:
        The lane changes; None if the lane is too short for them.
    """
    if count == 0:
        return []
    first = AFTER_LANE_BEGIN if lane.acceleration else AFTER_JUNCTION
    is_long = lane.length > LONG_EDGE and not lane.acceleration
    last = lane.length - (QUEUE_ZONE if is_long else BEFORE_STOP_LINE)
    available = (last - first - (count - 1) * CHANGE_GAP) / count
    length = min(available, max(CHANGE_USUAL, CHANGE_TIME * lane.speed_limit))
    if length < CHANGE_LEAST:
        return None
    slack = last - first - count * length - (count - 1) * CHANGE_GAP
    start = first + slack * (0.5 if lane.acceleration else LATER_SHARE if is_long else 0.0)
    step = length + CHANGE_GAP
    return [ChangeSpan(start + i * step, start + i * step + length) for i in range(count)]


def _fits(lane: Lane, changes: int) -> bool:
    return change_spans(lane, abs(changes)) is not None


def _onward(town: Town, way: _Way, link: Link, changes: int) -> _Way:
    lanes = town.edges[town.lanes[link.target].edge]
    from_right = next(i for i, lane in enumerate(lanes) if lane.id == link.target)
    return _Way(
        way.cost + changes + KEEP_RIGHT * from_right,
        (*way.entered, link.target),
        (*way.left, link.source),
        (*way.links, link),
    )
