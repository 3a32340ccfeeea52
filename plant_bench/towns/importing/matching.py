"""Which lanes a sparse route takes: the likeliest sequence of places on lanes (Viterbi).

A place is likely that is near its point, at its height and in its direction; a step from place to
place that is not much longer than the straight line.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.towns.importing.carla_routes import CarlaRoute
from plant_bench.towns.importing.lane_graph import LaneGraph, OnLane

SEARCH = 6.0  # m around a point that lanes are looked for
SPREAD = 0.7  # m: standard deviation of a point from its lane
HEADING_SPREAD = 0.4  # rad
HEADING_MOST = 1.8  # rad: lanes that run the other way are none
HEIGHT_SPREAD = 1.5  # m
DETOUR_SPREAD = 8.0  # m that a way is longer than the straight line
DETOUR_MOST = 3.0  # times the straight line, and
DETOUR_FREE = 200.0  # m that a way may be long


class UnmatchedError(Exception):
    """Raised where a route does not fit: says where and why."""

    def __init__(self, point: int, why: str) -> None:
        super().__init__(f"point {point}: {why}")
        self.point = point
        self.why = why


@dataclass(frozen=True)
class _Steps:
    """The best ways to the places of one point: costs so far, and from which place each came."""

    places: list[OnLane]
    costs: list[float]
    before: list[int]


def match(ways: LaneGraph, route: CarlaRoute) -> list[OnLane]:
    """Return the likeliest places of a route's points, one each.

    Args:
        ways: The town's lanes.
        route: The route, its points in the town's coordinates.

    Raises:
        UnmatchedError: A point has no lane near, or there is no way from one to the next.
    """
    use_height = ways.has_levels and float(np.ptp(route.points[:, 2])) > 0.5
    steps: list[_Steps] = []
    for number in range(len(route.points)):
        places, costs = _places(ways, route, number, use_height=use_height)
        if steps:
            straight = float(np.hypot(*(route.points[number] - route.points[number - 1])[:2]))
            steps.append(_onward(ways, steps[-1], places, costs, straight))
            if not np.isfinite(steps[-1].costs).any():
                raise UnmatchedError(number, f"no way leads there from point {number - 1}")
        else:
            steps.append(_Steps(places, costs, [-1] * len(places)))
    return _best(steps)


def _places(
    ways: LaneGraph, route: CarlaRoute, number: int, *, use_height: bool
) -> tuple[list[OnLane], list[float]]:
    x, y, z = (float(value) for value in route.points[number])
    near = ways.near(x, y, SEARCH)
    if not near:
        away = ways.distance_to_nearest(x, y)
        raise UnmatchedError(number, f"the nearest lane is {away:.1f} m away")
    heading = float(route.headings[number])
    places, costs = [], []
    for place in near:
        turned = 0.0 if np.isnan(heading) else abs(wrap_angle(place.heading - heading))
        if turned > HEADING_MOST:
            continue
        cost = (place.away / SPREAD) ** 2 + (turned / HEADING_SPREAD) ** 2
        cost += ((place.z - z) / HEIGHT_SPREAD) ** 2 if use_height else 0.0
        places.append(place)
        costs.append(0.5 * cost)
    if not places:
        raise UnmatchedError(number, "the lanes there run in another direction")
    return places, costs


def _onward(
    ways: LaneGraph, last: _Steps, places: list[OnLane], costs: list[float], straight: float
) -> _Steps:
    totals, before = [], []
    for place, cost in zip(places, costs, strict=True):
        found = [
            so_far + _step_cost(ways, earlier, place, straight)
            for earlier, so_far in zip(last.places, last.costs, strict=True)
        ]
        best = int(np.argmin(found))
        totals.append(found[best] + cost)
        before.append(best)
    return _Steps(places, totals, before)


def _step_cost(ways: LaneGraph, start: OnLane, goal: OnLane, straight: float) -> float:
    way = ways.way(start, goal)
    if way is None or way.metres > DETOUR_MOST * straight + DETOUR_FREE:
        return np.inf
    return abs(way.metres - straight) / DETOUR_SPREAD


def _best(steps: list[_Steps]) -> list[OnLane]:
    place = int(np.argmin(steps[-1].costs))
    found = []
    for step in reversed(steps):
        found.append(step.places[place])
        place = step.before[place]
    return found[::-1]


def lanes_driven(ways: LaneGraph, places: list[OnLane]) -> list[tuple[str, list[float]]]:
    """Return the lanes of a matched route in order, each with the places matched on it, rising."""
    visits: list[tuple[str, list[float]]] = [(places[0].lane, [places[0].at])]
    for start, goal in pairwise(places):
        way = ways.way(start, goal)
        for lane in way.lanes[1:] if way is not None else ():
            visits.append((lane, []))
        anchors = visits[-1][1]
        anchors.append(max(goal.at, anchors[-1]) if anchors else goal.at)
    return visits
