"""Lanes, junctions and adjacent lanes along a route, for the placement of hazards."""

from functools import cached_property

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.world.route import LaneSpan, Route
from plant_bench.world.town import Lane, Town

STEP = 5  # m between candidate places
MARGIN = 40.0  # m without hazards at both ends of a route
STRAIGHT = 0.12  # rad: largest change of heading on a straight stretch
FAR = 1e6  # m: distance if there is no junction
MERGE_RUN = 150.0  # m of straight approach of a vehicle on an adjacent lane
OPPOSITE = 2.4  # rad: smallest difference of the headings of a lane and an oncoming lane


class Track:
    """The lanes and junctions along a route, by arc length; immutable."""

    def __init__(self, town: Town, route: Route) -> None:
        self.town = town
        self.route = route
        metres = np.arange(int(route.length) + 1)
        before, after = np.full(len(metres), FAR), np.full(len(metres), FAR)
        for passage in route.passages:
            gone, left = metres - passage.exit, passage.entry - metres
            before = np.where(gone >= 0.0, np.minimum(before, gone), before)
            after = np.where(left >= 0.0, np.minimum(after, left), after)
            inside = (metres > passage.entry) & (metres < passage.exit)
            before[inside] = after[inside] = 0.0
        self._before, self._after = before, after
        self._oncoming: dict[str, bool] = {}

    @property
    def places(self) -> list[float]:
        """Arc lengths of the candidate places, without the route's ends, metres."""
        return [
            float(at) for at in range(int(MARGIN) + STEP, int(self.route.length - MARGIN), STEP)
        ]

    def junction_distances(self, at: float) -> tuple[float, float]:
        """Return the distances to the previous and to the next junction, metres."""
        return float(self._before[int(at)]), float(self._after[int(at)])

    def limit(self, at: float) -> float:
        """Return the ego's speed limit, m/s."""
        return float(np.interp(at, self.route.along, self.route.speed_limits))

    def distance_between(self, one: float, other: float) -> float:
        """Return the straight-line distance between two places on the route, metres."""
        route = self.route
        x, y = (np.interp((one, other), route.along, column) for column in route.points.T)
        return float(np.hypot(x[1] - x[0], y[1] - y[0]))

    def span(self, at: float) -> LaneSpan:
        """Return the lane span at an arc length."""
        spans = self.route.lanes
        return next((span for span in spans if span.start <= at < span.end), spans[-1])

    def lane(self, at: float) -> Lane:
        """Return the lane at an arc length."""
        return self.town.lanes[self.span(at).lane]

    def keeps_lane(self, start: float, end: float) -> bool:
        """Return whether the route has no lane change between two arc lengths."""
        changes = self.route.lane_changes
        return all(change.end < start or change.start > end for change in changes)

    def is_straight(self, start: float, end: float) -> bool:
        """Return whether the route is straight between two arc lengths."""
        route = self.route
        part = route.headings[(route.along >= start) & (route.along <= end)]
        return bool(len(part)) and float(part.max() - part.min()) < STRAIGHT

    def is_kerb(self, lane: Lane) -> bool:
        """Return whether a lane is the rightmost of its road."""
        return lane.junction is None and lane.right is None and not lane.acceleration

    def sides(self, lane: Lane) -> tuple[int, ...]:
        """Return the sides from which pedestrians may cross.

        Left (1) only if there is exactly one oncoming lane to cross.
        """
        alone = lane.left is None and not self._on_ring(lane)
        return (-1, 1) if alone and self.has_oncoming(lane) else (-1,)

    def has_oncoming(self, lane: Lane) -> bool:
        """Return whether exactly one oncoming lane is beside a lane."""
        if lane.id not in self._oncoming:
            self._oncoming[lane.id] = self._count_oncoming(lane) == 1
        return self._oncoming[lane.id]

    def _count_oncoming(self, lane: Lane) -> int:
        x, y, heading = _pose(lane, 0.5 * lane.length)
        beside = 0
        for other, middle in self._middles:
            if np.hypot(*(middle - (x, y))) < lane.length:
                ox, oy, back = _nearest_pose(other, x, y)
                left = (oy - y) * np.cos(heading) - (ox - x) * np.sin(heading)
                beside += 0.0 < left < 8.0 and _between(heading, back) > OPPOSITE
        return int(beside)

    def approach_length(self, at: float) -> float:
        """Return the length of the straight approach to a place on its own lane, metres."""
        lane = self.lane(at)
        x, y = (float(np.interp(at, self.route.along, column)) for column in self.route.points.T)
        apart = np.hypot(lane.points[:, 0] - x, lane.points[:, 1] - y)
        run = float(lane.along[apart.argmin()])
        while run < MERGE_RUN and (before := self._before_straight(lane)) is not None:
            lane, via = before
            run += lane.length + via
        return run

    def _before_straight(self, lane: Lane) -> tuple[Lane, float] | None:
        for link in self.town.links:
            if link.target == lane.id and link.turn == "straight":
                via = sum(self.town.lanes[name].length for name in link.via)
                return self.town.lanes[link.source], via
        return None

    @cached_property
    def _middles(self) -> list[tuple[Lane, np.ndarray]]:
        lanes = [lane for lane in self.town.lanes.values() if lane.junction is None]
        return [(lane, lane.points[len(lane.points) // 2, :2]) for lane in lanes]

    def _on_ring(self, lane: Lane) -> bool:
        return any(lane.edge in ring for ring in self.town.roundabouts)


def _between(one: float, other: float) -> float:
    return abs(wrap_angle(one - other))


def _pose(lane: Lane, at: float) -> tuple[float, float, float]:
    x, y = (np.interp((at, at + 1.0), lane.along, column) for column in lane.points.T[:2])
    return float(x[0]), float(y[0]), float(np.arctan2(y[1] - y[0], x[1] - x[0]))


def _nearest_pose(lane: Lane, x: float, y: float) -> tuple[float, float, float]:
    at = np.arange(0.0, lane.length, 1.0)
    px, py = (np.interp(at, lane.along, column) for column in lane.points.T[:2])
    best = int(np.argmin(np.hypot(px - x, py - y)))
    return _pose(lane, float(at[best]))
