"""Map matching: the most likely sequence of lane positions for a sparse route (Viterbi).

A position is likely if it is close to its point in distance, height and heading; a transition is
likely if its path is not much longer than the straight line.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.towns.importing.carla_routes import CarlaRoute
from plant_bench.towns.importing.lane_graph import LaneGraph, LanePosition

SEARCH_RADIUS = 6.0  # m around a point in which lanes are considered; more if none is so near
WRONG_MAP = 50.0  # m from the nearest lane beyond which a point is taken to be of another map
SPREAD = 0.7  # m: standard deviation of a point from its lane
HEADING_SPREAD = 0.4  # rad, standard deviation
MAX_HEADING_ERROR = 1.8  # rad; excludes lanes of the other direction
HEIGHT_SPREAD = 1.5  # m, standard deviation
DETOUR_SPREAD = 8.0  # m: scale of the cost of a path longer than the straight line
MAX_DETOUR = 3.0  # a path may be this many times the straight line,
DETOUR_MARGIN = 200.0  # m plus this long


class UnmatchedError(Exception):
    """Raised if a route does not fit the lanes; has the index of the point and the reason."""

    def __init__(self, point: int, reason: str) -> None:
        super().__init__(f"point {point}: {reason}")
        self.point = point
        self.reason = reason


@dataclass(frozen=True)
class _Steps:
    """Viterbi state of one point: candidate positions, their costs so far, and predecessors."""

    places: list[LanePosition]
    costs: list[float]
    before: list[int]


def match(graph: LaneGraph, route: CarlaRoute, limit: float) -> list[LanePosition]:
    """Return the most likely position of each of a route's points.

    Args:
        graph: The town's lanes.
        route: The route, its points in the town's coordinates.
        limit: Distance within which lanes are considered if none is within `SEARCH_RADIUS`, metres.

    Raises:
        UnmatchedError: No lane is near a point, or no path leads to a point from the one before.
    """
    use_height = graph.has_levels and float(np.ptp(route.points[:, 2])) > 0.5
    steps: list[_Steps] = []
    for number in range(len(route.points)):
        places, costs = _candidates(graph, route, number, limit, use_height=use_height)
        if steps:
            straight = float(np.hypot(*(route.points[number] - route.points[number - 1])[:2]))
            steps.append(_transition(graph, steps[-1], places, costs, straight))
            if not np.isfinite(steps[-1].costs).any():
                raise UnmatchedError(number, f"no path leads there from point {number - 1}")
        else:
            steps.append(_Steps(places, costs, [-1] * len(places)))
    return _backtrack(steps)


def _candidates(
    graph: LaneGraph, route: CarlaRoute, number: int, limit: float, *, use_height: bool
) -> tuple[list[LanePosition], list[float]]:
    x, y, z = (float(value) for value in route.points[number])
    near = graph.near(x, y, SEARCH_RADIUS) or graph.near(x, y, limit)
    if not near:
        away = graph.distance_to_nearest(x, y)
        reason = f"the nearest lane is {away:.0f} m away: is it the right map?"
        if away <= WRONG_MAP:
            larger = math.ceil(away + 0.5)
            reason = f"the nearest lane is {away:.1f} m away; try --limit-distance {larger}"
        raise UnmatchedError(number, reason)
    heading = float(route.headings[number])
    places, costs = [], []
    for place in near:
        turned = 0.0 if np.isnan(heading) else abs(wrap_angle(place.heading - heading))
        if turned > MAX_HEADING_ERROR:
            continue
        cost = (place.away / SPREAD) ** 2 + (turned / HEADING_SPREAD) ** 2
        cost += ((place.z - z) / HEIGHT_SPREAD) ** 2 if use_height else 0.0
        places.append(place)
        costs.append(0.5 * cost)
    if not places:
        raise UnmatchedError(number, "all lanes near it have another direction")
    return places, costs


def _transition(
    graph: LaneGraph, last: _Steps, places: list[LanePosition], costs: list[float], straight: float
) -> _Steps:
    totals, before = [], []
    for place, cost in zip(places, costs, strict=True):
        found = [
            so_far + _step_cost(graph, earlier, place, straight)
            for earlier, so_far in zip(last.places, last.costs, strict=True)
        ]
        best = int(np.argmin(found))
        totals.append(found[best] + cost)
        before.append(best)
    return _Steps(places, totals, before)


def _step_cost(graph: LaneGraph, start: LanePosition, goal: LanePosition, straight: float) -> float:
    path = graph.shortest_path(start, goal)
    if path is None or path.metres > MAX_DETOUR * straight + DETOUR_MARGIN:
        return np.inf
    return abs(path.metres - straight) / DETOUR_SPREAD


def _backtrack(steps: list[_Steps]) -> list[LanePosition]:
    place = int(np.argmin(steps[-1].costs))
    found = []
    for step in reversed(steps):
        found.append(step.places[place])
        place = step.before[place]
    return found[::-1]


def lanes_driven(graph: LaneGraph, places: list[LanePosition]) -> list[tuple[str, list[float]]]:
    """Return the lanes of a matched route in order, each with its matched arc lengths, rising."""
    visits: list[tuple[str, list[float]]] = [(places[0].lane, [places[0].at])]
    for start, goal in pairwise(places):
        path = graph.shortest_path(start, goal)
        for lane in path.lanes[1:] if path is not None else ():
            visits.append((lane, []))
        anchors = visits[-1][1]
        anchors.append(max(goal.at, anchors[-1]) if anchors else goal.at)
    return visits
