"""Finds approaches through a junction that conflict with the ego's route, and conflict points."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.box import overlap
from plant_bench.geometry.polyline import arc_lengths, without_repeats
from plant_bench.geometry.pose import wrap_angle
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH
from plant_bench.world.town import Lane, Link, Town

TOUCH = 1.2  # m between two centre lines at a conflict point
BEYOND = 12.0  # m behind the junction within which paths may still conflict
STEP = 0.5  # m between checked positions
SWEPT = (5.8, 2.9)  # m: the box of a large vehicle with half a metre around it
SIDEWAYS = math.radians(45.0)  # from the ego's heading, at which a street is a cross street
ONCOMING = math.radians(135.0)  # at which it is the opposite one
FROM_LEFT, SPREAD = math.radians(-90.0), math.radians(50.0)  # of vehicles from the left


@dataclass(frozen=True, eq=False)
class Approach:
    """A path through a junction that conflicts with the ego's route.

    Attributes:
        link: The link through the junction.
        line: Centre line from the start of the incoming lanes to the end of the outgoing one.
        starts: Arc length on the line at which each lane starts, by lane id, in order.
        edges: The edges along the line.
        stop: Arc length of the stop line on the line.
        meets: Arc length of the first conflict point on the line.
        at: Arc length of the same point on the ego's route.
        clear: Arc length on the ego's route that its front must not pass to let others pass.
        angle: Angle from the ego's heading before the junction to the other's, radians.
    """

    link: Link
    line: Float[np.ndarray, "points 2"]
    starts: dict[str, float]
    edges: tuple[str, ...]
    stop: float
    meets: float
    at: float
    clear: float
    angle: float

    @cached_property
    def along(self) -> Float[np.ndarray, " points"]:
        """Arc length of each point of the line, metres."""
        return arc_lengths(self.line)


def passage_at(route: Route, at: float) -> Passage | None:
    """Return the route's passage at an arc length, the nearest one within 10 m."""
    near = [item for item in route.passages if item.entry - 10.0 <= at <= item.exit + 10.0]
    return min(near, key=lambda item: abs(0.5 * (item.entry + item.exit) - at), default=None)


def approaches(town: Town, route: Route, passage: Passage) -> list[Approach]:
    """Return the approaches from other streets that conflict with a passage, in a fixed order."""
    heading = float(np.interp(passage.entry - 2.0, route.along, route.headings))
    edges = set(route.edges)
    found = []
    for link in town.links:
        if link.junction == passage.junction and link.via and link.source in town.lanes:
            source = town.lanes[link.source]
            if source.edge in edges and _same_heading(source, heading):
                continue
            approach = _approach(town, link, route, passage, heading)
            if approach is not None:
                found.append(approach)
    return sorted(found, key=lambda item: (item.link.source, item.link.target))


def clear_place(
    route: Route, first: float, last: float, line: Float[np.ndarray, "points 2"], stretch: range
) -> float:
    """Return how far the ego's front may go without conflict with vehicles on a line.

    Args:
        route: The ego's route.
        first: Arc length on the route of the ego's centre at the first checked position.
        last: The same at the last checked position.
        line: The centre line of the other vehicles.
        stretch: Arc lengths on the line at which their centres may be, metres.

    Returns:
        Arc length of the route: the ego's front at the first place where its box touches theirs,
        or the last one.
    """
    centres = np.arange(first, last, STEP)
    own = _poses(route.points, route.along, centres)
    other = _poses(line, arc_lengths(line), np.arange(stretch.start, stretch.stop, STEP))
    pairs = len(own) * len(other)
    touches = overlap(
        np.repeat(own, len(other), axis=0),
        np.tile(EGO_EXTENT, (pairs, 1)),
        np.tile(other, (len(own), 1)),
        np.tile(SWEPT, (pairs, 1)),
    )
    rows = np.flatnonzero(touches.reshape(len(own), len(other)).any(axis=1))
    return float(centres[rows[0]] if rows.size else last) + 0.5 * EGO_LENGTH


def _poses(
    points: Float[np.ndarray, "points 2"],
    along: Float[np.ndarray, " points"],
    places: Float[np.ndarray, " steps"],
) -> Float[np.ndarray, "steps 3"]:
    x, y = (np.interp(places, along, points[:, axis]) for axis in (0, 1))
    ahead = [np.interp(places + 1.0, along, points[:, axis]) for axis in (0, 1)]
    behind = [np.interp(places - 1.0, along, points[:, axis]) for axis in (0, 1)]
    yaw = np.arctan2(ahead[1] - behind[1], ahead[0] - behind[0])
    return np.stack((x, y, yaw), axis=1)


def _same_heading(lane: Lane, heading: float) -> bool:
    return math.cos(_heading_at_end(lane) - heading) > 0.9


def _heading_at_end(lane: Lane) -> float:
    dx, dy = lane.points[-1, :2] - lane.points[-2, :2]
    return math.atan2(dy, dx)


def _approach(
    town: Town, link: Link, route: Route, passage: Passage, heading: float
) -> Approach | None:
    first = town.lanes[link.source]
    lanes = [first, *(town.lanes[via] for via in link.via), town.lanes[link.target]]
    while (before := joined_before(town, lanes[0].id)) is not None and len(lanes) < 8:
        lanes.insert(0, town.lanes[before])
    line = joined_line(lanes)
    starts = lane_starts(lanes)
    stop = starts[link.via[0]]
    end = starts[link.target] + min(BEYOND, lanes[-1].length)
    where = np.arange(stop, end, STEP)
    other = _poses(line, arc_lengths(line), where)
    span = np.arange(passage.entry, passage.exit + BEYOND, 1.0)
    own = _poses(route.points, route.along, span)
    apart = np.hypot(*(own[:, None, :2] - other[None, :, :2]).transpose(2, 0, 1))
    if apart.min(initial=math.inf) > TOUCH:
        return None
    mine = int(np.argmax(apart.min(axis=1) <= TOUCH))
    theirs = int(np.argmin(apart[mine]))
    begin = passage.entry - 0.5 * EGO_LENGTH
    return Approach(
        link=link,
        line=line,
        starts=starts,
        edges=tuple(lane.edge for lane in lanes if lane.junction is None),
        stop=stop,
        meets=float(where[theirs]),
        at=float(span[mine]),
        clear=clear_place(route, begin, passage.exit + BEYOND, line, range(int(stop), int(end))),
        angle=wrap_angle(_heading_at_end(first) - heading),
    )


def joined_line(lanes: list[Lane]) -> Float[np.ndarray, "points 2"]:
    """Return the centre line of lanes that follow each other."""
    return without_repeats(np.concatenate([lane.points[:, :2] for lane in lanes]))


def lane_starts(lanes: list[Lane]) -> dict[str, float]:
    """Return the arc length at which each of the lanes that follow each other begins."""
    ends = np.cumsum([0.0, *(lane.length for lane in lanes)]).tolist()
    return {lane.id: start for lane, start in zip(lanes, ends[:-1], strict=True)}


def joined_before(town: Town, lane: str) -> str | None:
    """Return the lane before a lane at a joint of two edges."""
    for link in town.links:
        if link.target == lane and not link.via:
            return link.source
    return None


def crosses(way: Approach, passage: Passage) -> bool:
    """Tell whether an approach crosses the ego's path from a cross street, at lights."""
    sideways = SIDEWAYS < abs(way.angle) < math.pi - SIDEWAYS
    return passage.signal is not None and sideways and way.link.turn != "right"


def joins_from_left(way: Approach, passage: Passage) -> bool:
    """Tell whether an approach leads from the left into the lane that the ego turns right into."""
    from_left = abs(way.angle - FROM_LEFT) < SPREAD
    return passage.turn == "right" and from_left and way.link.turn == "straight"


def is_unsignalled(way: Approach, passage: Passage) -> bool:
    """Tell whether an approach conflicts with the ego at a junction without signals."""
    return passage.signal is None and way.link.signal is None


def is_oncoming(way: Approach, passage: Passage) -> bool:
    """Tell whether an approach is oncoming and has priority over the ego turning left."""
    opposite = abs(way.angle) > ONCOMING and way.link.turn != "left"
    return passage.turn == "left" and passage.signal is not None and opposite
