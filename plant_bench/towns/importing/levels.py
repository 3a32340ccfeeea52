"""Roads that cross at one height without a junction: lifted over each other where there is room.

Two vehicles at one place and height have collided, whatever their roads; so crossings need levels.
"""

from collections import defaultdict
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry import LineString, Point

from plant_bench.towns.importing.map_findings import Finding, repaired, reported
from plant_bench.towns.importing.net_edits import Place, with_lifts
from plant_bench.world.town import Lane, Town

LEVELS_APART = 4.0  # m of height between roads that do not meet
ROOM = 75.0  # m from the crossing to the upper road's ends: it rises over 60 m

Ends = Mapping[str, tuple[str, str]]


class Crossing(NamedTuple):
    """Two edges that cross at one height.

    Attributes:
        one: An edge.
        other: Another.
        place: Where, x and y.
        rooms: Metres from there to the nearer end of each edge.
    """

    one: str
    other: str
    place: Place
    rooms: tuple[float, float]


def flat_crossings(town: Town, ends: Ends) -> list[Crossing]:
    """Return the pairs of edges that cross without a junction and without a difference in height.

    Args:
        town: The town.
        ends: The junctions at each edge's begin and end.
    """
    lanes = [lanes[0] for lanes in town.edges.values()]
    lines = [LineString(lane.points[:, :2]) for lane in lanes]
    pairs = shapely.STRtree(lines).query(lines, predicate="crosses").T.tolist()
    found = []
    for i, j in sorted(pairs):
        if i < j and not set(ends[lanes[i].edge]) & set(ends[lanes[j].edge]):
            for part in shapely.get_parts(shapely.intersection(lines[i], lines[j])):
                crossing = _crossing((lanes[i], lanes[j]), (lines[i], lines[j]), part.centroid)
                found += [] if crossing is None else [crossing]
    return found


def _crossing(
    lanes: tuple[Lane, Lane], lines: tuple[LineString, LineString], at: Point
) -> Crossing | None:
    along = [line.project(at) for line in lines]
    heights = [_height(lane, place) for lane, place in zip(lanes, along, strict=True)]
    if abs(heights[0] - heights[1]) >= LEVELS_APART:
        return None
    rooms = [min(place, line.length - place) for place, line in zip(along, lines, strict=True)]
    place = (round(at.x, 2), round(at.y, 2))
    return Crossing(lanes[0].edge, lanes[1].edge, place, (float(rooms[0]), float(rooms[1])))


def _height(lane: Lane, along: float) -> float:
    return float(np.interp(along, lane.along, lane.points[:, 2]))


def lift_crossings(net: str, town: Town, ends: Ends) -> tuple[str, list[Finding]]:
    """Lift one road over the other wherever two cross at one height and there is room for ramps.

    Returns:
        The network (XML text) to be converted again, and what was lifted; empty if nothing.
    """
    crossings = flat_crossings(town, ends)
    rooms: dict[frozenset[str], float] = {}  # a road is what joins two junctions, in both ways
    for item in crossings:
        for edge, room in zip((item.one, item.other), item.rooms, strict=True):
            road = frozenset(ends[edge])
            rooms[road] = min(room, rooms.get(road, np.inf))
    lifts: dict[str, list[Place]] = defaultdict(list)
    for item in crossings:
        edges = sorted((item.one, item.other), key=lambda e: _rank(rooms, frozenset(ends[e])))
        if rooms[frozenset(ends[edges[-1]])] >= ROOM:
            lifts[edges[-1]].append(item.place)
    done = "one lifted over the other"
    return with_lifts(net, lifts) if lifts else net, repaired(
        "roads that cross at one height", done, sorted(lifts)
    )


def _rank(rooms: Mapping[frozenset[str], float], road: frozenset[str]) -> tuple[float, list[str]]:
    return rooms[road], sorted(road)


def report_flat_crossings(town: Town, ends: Ends) -> list[Finding]:
    """Report the crossings that are still at one height."""
    names = [f"{item.one} and {item.other}" for item in flat_crossings(town, ends)]
    done = "their vehicles collide: the roads are too short to be lifted, give the map heights"
    return reported("roads that cross at one height", done, names)
