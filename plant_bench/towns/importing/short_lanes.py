"""Straightens lanes shorter than a metre, whose direction SUMO may have reversed.

Where an edge is shorter than the junctions at its ends reach, SUMO draws its lanes 0.2 m long,
often backwards, and the lanes inside the junctions go back as well. A line along such lanes has
cusps that no car can follow, although the road itself is smooth.
"""

from collections import deque
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from plant_bench.world.town import Lane, Town

SHORT = 1.0  # m: shorter lanes may be drawn backwards,
SHORT_INSIDE = 10.0  # m: inside junctions longer ones, too, where junctions overlap
REVERSED = -0.5  # cosine of the angle to the lanes around, below which a lane is reversed
LOOK = 3.0  # m of lane from which a heading is taken
HALF = 0.05  # m: half the length of a straightened lane
COLLAPSED = 2  # points of a lane that is cut to its minimum
MAX_CUT = 1.5  # m, and share of the reversed lane's length: what a neighbour is cut by, at most
MAX_CUT_SHARE = 0.7

Point = Float[np.ndarray, " 2"]


def straighten_short_lanes(town: Town) -> Town:
    """Return a town in which no short lane, and no lane in a junction, leads backwards.

    A reversed lane becomes a piece of 0.1 m at its middle, in the direction of the lanes before and
    after it. Those are cut or extended to meet it, by at most `MAX_CUT`.
    """
    lanes = dict(town.lanes)
    after = {lane.id: list(lane.successors) for lane in lanes.values()}
    before: dict[str, list[str]] = {}
    for name, successors in after.items():
        for successor in successors:
            before.setdefault(successor, []).append(name)
    waiting = deque(
        lane.id
        for lane in lanes.values()
        if lane.length < (SHORT if lane.junction is None else SHORT_INSIDE)
    )
    collapsed: dict[str, float] = {}  # lanes cut to a point, and how far; neighbours follow
    left = 10 * len(waiting)
    while waiting and left:
        left -= 1
        lane = lanes[waiting.popleft()]
        heading = _heading_around(lanes, lane.id, before, after)
        ends = lane.points[-1, :2] - lane.points[0, :2]
        size = float(np.hypot(*ends))
        is_reversed = heading is not None and float(ends @ heading) < REVERSED * size
        if heading is None or not (is_reversed or lane.id in collapsed):
            continue
        most = max(MAX_CUT, MAX_CUT_SHARE * size, collapsed.pop(lane.id, 0.0))
        middle = 0.5 * (lane.points[0] + lane.points[-1])
        step = HALF * np.append(heading, 0.0)
        start, end = middle - step, middle + step
        cut = {
            name: _cut_end(lanes[name], start, heading, most) for name in before.get(lane.id, [])
        }
        cut |= {name: _cut_start(lanes[name], end, heading, most) for name in after[lane.id]}
        meeting = {name: points for name, points in cut.items() if points is not None}
        if len(meeting) < len(cut):
            continue
        lanes[lane.id] = replace(lane, points=np.stack((start, end)))
        for name, points in meeting.items():
            lanes[name] = replace(lanes[name], points=points)
            if lanes[name].length < SHORT:
                waiting.append(name)
                if len(points) == COLLAPSED:
                    collapsed[name] = most
    return replace(town, lanes=lanes)


def _heading_around(
    lanes: dict[str, Lane], name: str, before: dict[str, list[str]], after: dict[str, list[str]]
) -> Point | None:
    """Return the mean direction of the nearest lanes before and after that are not short."""
    directions = [
        _direction(lanes[other], at_end=table is before)
        for table in (before, after)
        for other in _nearest_long(lanes, name, table)
    ]
    total = np.sum(directions, axis=0) if directions else np.zeros(2)
    size = float(np.linalg.norm(total))
    return None if size < 1e-6 else total / size


def _nearest_long(lanes: dict[str, Lane], name: str, table: dict[str, list[str]]) -> list[str]:
    found, seen, waiting = [], {name}, deque(table.get(name, ()))
    while waiting:
        other = waiting.popleft()
        if other in seen:
            continue
        seen.add(other)
        if lanes[other].length >= SHORT:
            found.append(other)
        else:
            waiting.extend(table.get(other, ()))
    return found


def _direction(lane: Lane, *, at_end: bool) -> Point:
    """Return a lane's direction near its end or its start, over `LOOK` metres."""
    length = lane.length
    at = (max(length - LOOK, 0.0), length) if at_end else (0.0, min(LOOK, length))
    first, last = (
        np.array([np.interp(place, lane.along, column) for column in lane.points[:, :2].T])
        for place in at
    )
    return (last - first) / max(float(np.hypot(*(last - first))), 1e-9)


def _cut_end(lane: Lane, end: np.ndarray, heading: Point, most: float) -> np.ndarray | None:
    """Return a lane's points so that it ends at a point; None if that would cut too much."""
    ahead = (lane.points[:, :2] - end[:2]) @ heading > -1e-3
    kept = lane.points[~(ahead & (lane.along >= lane.length - most))]
    if not len(kept):
        return np.stack((end - HALF * np.append(heading, 0.0), end))
    is_beyond = bool((kept[-1, :2] - end[:2]) @ heading > 0.0)
    return None if is_beyond else np.concatenate((kept, end[None]))


def _cut_start(lane: Lane, start: np.ndarray, heading: Point, most: float) -> np.ndarray | None:
    """Return a lane's points so that it begins at a point; None if that would cut too much."""
    behind = (lane.points[:, :2] - start[:2]) @ heading < 1e-3
    kept = lane.points[~(behind & (lane.along <= most))]
    if not len(kept):
        return np.stack((start, start + HALF * np.append(heading, 0.0)))
    is_before = bool((kept[0, :2] - start[:2]) @ heading < 0.0)
    return None if is_before else np.concatenate((start[None], kept))
