"""Finds roads that cross at the same height without a junction, and raises one over the other.

Vehicles that overlap at the same height count as collided, so such roads must differ in height.
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

LEVELS_APART = 4.0  # m of height between roads that cross without a junction
RAMP_SPACE = 75.0  # m from the crossing to the upper road's ends: it rises over 60 m

Ends = Mapping[str, tuple[str, str]]


class Crossing(NamedTuple):
    """Two edges that cross at the same height.

    Attributes:
        one: Id of the first edge.
        other: Id of the second edge.
        place: Position of the crossing, x and y.
        ramp_lengths: Distance from there to the nearer end of each edge, metres.
    """

    one: str
    other: str
    place: Place
    ramp_lengths: tuple[float, float]


def flat_crossings(town: Town, ends: Ends) -> list[Crossing]:
    """Return the pairs of edges that cross at the same height without a junction.

    Args:
        town: The town.
        ends: The junctions at each edge's start and end.
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
    ramp_lengths = [
        min(place, line.length - place) for place, line in zip(along, lines, strict=True)
    ]
    place = (round(at.x, 2), round(at.y, 2))
    return Crossing(
        lanes[0].edge, lanes[1].edge, place, (float(ramp_lengths[0]), float(ramp_lengths[1]))
    )


def _height(lane: Lane, along: float) -> float:
    return float(np.interp(along, lane.along, lane.points[:, 2]))


def lift_crossings(net: str, town: Town, ends: Ends) -> tuple[str, list[Finding]]:
    """Raise one road over the other where two cross at the same height and ramps fit.

    Returns:
        The network (XML text) to be converted again, and the findings; empty if nothing was raised.
    """
    crossings = flat_crossings(town, ends)
    ramp_lengths: dict[frozenset[str], float] = {}  # a road: both directions between two junctions
    for item in crossings:
        for edge, length in zip((item.one, item.other), item.ramp_lengths, strict=True):
            road = frozenset(ends[edge])
            ramp_lengths[road] = min(length, ramp_lengths.get(road, np.inf))
    lifts: dict[str, list[Place]] = defaultdict(list)
    for item in crossings:
        edges = sorted(
            (item.one, item.other), key=lambda e: _rank(ramp_lengths, frozenset(ends[e]))
        )
        if ramp_lengths[frozenset(ends[edges[-1]])] >= RAMP_SPACE:
            lifts[edges[-1]].append(item.place)
    done = "one road raised over the other"
    return with_lifts(net, lifts) if lifts else net, repaired(
        "roads that cross at the same height", done, sorted(lifts)
    )


def _rank(
    ramp_lengths: Mapping[frozenset[str], float], road: frozenset[str]
) -> tuple[float, list[str]]:
    return ramp_lengths[road], sorted(road)


def report_flat_crossings(town: Town, ends: Ends) -> list[Finding]:
    """Report the crossings that are still at the same height."""
    names = [f"{item.one} and {item.other}" for item in flat_crossings(town, ends)]
    done = "vehicles on them collide; the roads are too short for ramps: add heights to the map"
    return reported("roads that cross at the same height", done, names)
