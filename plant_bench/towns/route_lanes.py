"""Plans the lanes of an edge path, and where it changes lanes."""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from plant_bench.towns.route_graph import StreetGraph
from plant_bench.world.town import Lane, Link, Town

CHANGE_TIME = 3.0  # s that a lane change takes where there is room
CHANGE_USUAL = 25.0  # m, at least, where there is room
CHANGE_LEAST = 20.0  # m
CHANGE_GAP = 5.0  # m between two lane changes
AFTER_JUNCTION = 8.0  # m from the junction's exit to a lane change
BEFORE_STOP_LINE = 15.0  # m from a lane change to the stop line
AFTER_LANE_BEGIN = 20.0  # m on an acceleration lane before it is left
LONG_EDGE = 200.0  # m: longer edges leave a choice where to change
QUEUE_ZONE = 60.0  # m before the stop line where long edges are kept free of lane changes
LATER_SHARE = 0.25  # of the free room on a long edge lies before its lane changes
KEEP_RIGHT = 0.01  # lane changes that driving one lane farther left is worth


@dataclass(frozen=True)
class LanePlan:
    """The lanes of an edge path.

    Attributes:
        edges: The path.
        entered: The lane each edge is entered on; on the first edge, where the route starts.
        left: The lane each edge is left from; on the last edge, where the route ends.
        links: The ways between the edges, one fewer than edges.
    """

    edges: tuple[str, ...]
    entered: tuple[str, ...]
    left: tuple[str, ...]
    links: tuple[Link, ...]


class ChangeSpan(NamedTuple):
    """Where on a lane a lane change begins and ends, metres from the lane's begin."""

    start: float
    end: float


class _Way(NamedTuple):
    cost: float
    entered: tuple[str, ...]
    left: tuple[str, ...]
    links: tuple[Link, ...]


def plan_lanes(graph: StreetGraph, edges: tuple[str, ...]) -> LanePlan | None:
    """Choose lanes with the fewest lane changes, to the right where that makes no difference.

    The route starts on any lane of its first edge and changes no lane on its first and last edges.

    Returns:
        The plan, or None where lane changes would find no room.
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
    """Return how many lanes to the left of a lane another of its edge lies; negative: right."""
    ids = [item.id for item in town.edges[town.lanes[lane].edge]]
    return ids.index(other) - ids.index(lane)


def change_spans(lane: Lane, count: int) -> list[ChangeSpan] | None:
    """Place lane changes on an edge, one after the other.

    Args:
        lane: The lane they start from.
        count: How many.

    Returns:
        Their places, empty where there are none, or None where they find no room.
    """
    if count == 0:
        return []
    first = AFTER_LANE_BEGIN if lane.acceleration else AFTER_JUNCTION
    is_long = lane.length > LONG_EDGE and not lane.acceleration
    last = lane.length - (QUEUE_ZONE if is_long else BEFORE_STOP_LINE)
    room = (last - first - (count - 1) * CHANGE_GAP) / count
    length = min(room, max(CHANGE_USUAL, CHANGE_TIME * lane.speed_limit))
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
