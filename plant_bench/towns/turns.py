"""Assigns turns to the lanes of a junction, with turn lanes where an edge has several lanes."""

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.towns.street_plan import Edge, StreetPlan
from plant_bench.towns.street_shapes import end_pose, start_pose

REVERSING = float(np.radians(155))
SLIGHT = float(np.radians(30))


def connect_junction(plan: StreetPlan, node: str) -> None:
    """Connect all incoming lanes of a junction to its outgoing lanes.

    With several lanes, the leftmost only turns left and the rightmost also turns right, so left
    turns do not block other traffic. No two paths from one edge cross.
    """
    for edge in plan.arriving(node):
        for target, lanes in _lanes_by_target(edge, _targets(plan, edge)):
            plan.connect(edge.id, target.id, _pairs(edge, target, lanes))
    for target in plan.leaving(node):
        _feed_empty_lanes(plan, target)


def _targets(plan: StreetPlan, edge: Edge) -> list[Edge]:
    """Return the edges to which an edge may lead, from the rightmost turn to the leftmost."""
    onward = [t for t in plan.leaving(edge.end) if not _is_reverse(edge, t)]
    return sorted(onward, key=lambda target: turn_angle(edge, target))


def _is_reverse(edge: Edge, target: Edge) -> bool:
    """Return whether the target leads back: the same street, or nearly a half turn."""
    same_street = target.end == edge.start and len(edge.shape) == len(target.shape)
    if same_street and np.allclose(edge.shape, target.shape[::-1]):
        return True
    return abs(turn_angle(edge, target)) > REVERSING


def turn_angle(edge: Edge, target: Edge) -> float:
    """Return the change of heading from an edge to the next, radians, positive to the left."""
    return wrap_angle(start_pose(target.shape).heading - end_pose(edge.shape).heading)


def _lanes_by_target(edge: Edge, targets: list[Edge]) -> list[tuple[Edge, list[int]]]:
    """Return the lanes of the edge that serve each target, without crossing paths."""
    if edge.lanes == 1 or len(targets) == 1:
        return [(target, list(range(edge.lanes))) for target in targets]
    rights = [t for t in targets if turn_angle(edge, t) < -SLIGHT]
    lefts = [t for t in targets if turn_angle(edge, t) > SLIGHT]
    straight = [t for t in targets if t not in rights and t not in lefts]
    last = edge.lanes - 1
    first_free = 0 if straight or not rights else 1
    assigned = [(target, [0]) for target in rights]
    assigned += [(target, list(range(edge.lanes if not lefts else last))) for target in straight]
    left_lanes = [last] if straight else list(range(min(first_free, last), edge.lanes))
    return assigned + [(target, left_lanes) for target in lefts]


def _pairs(edge: Edge, target: Edge, lanes: list[int]) -> list[tuple[int, int]]:
    angle = turn_angle(edge, target)
    lanes = lanes[-target.lanes :] if angle > SLIGHT else lanes[: target.lanes]
    if angle > SLIGHT:
        top = target.lanes - len(lanes)
        return [(lane, top + index) for index, lane in enumerate(lanes)]
    return [(lane, index) for index, lane in enumerate(lanes)]


def _feed_empty_lanes(plan: StreetPlan, target: Edge) -> None:
    """Give each lane without a predecessor a connection from that of the nearest lane."""
    into = [c for c in plan.connections if c.end == target.id]
    fed = {c.end_lane for c in into}
    for lane in range(target.lanes):
        if lane in fed or not into:
            continue
        nearest = min(into, key=lambda c: (abs(c.end_lane - lane), c.start, c.start_lane))
        plan.connect(nearest.start, target.id, [(nearest.start_lane, lane)])
