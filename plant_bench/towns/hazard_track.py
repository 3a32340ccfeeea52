"""Lanes, junctions and adjacent lanes along a route, for the placement of hazards."""

from functools import cached_property

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.world.route import LaneSpan, Route
from plant_bench.world.town import Lane, Town

STEP = 5  # m between places looked at
MARGIN = 40.0  # m at the route's two ends without hazards
STRAIGHT = 0.12  # rad that a lane may turn over the metres a lane event takes
FAR = 1e6  # m to a junction that is not there
MERGE_RUN = 150.0  # m of straight approach of a vehicle beside the ego
OPPOSITE = 2.4  # rad between the headings of two neighbour lanes that lead opposite ways


class Track:
    """What lies along a route, metre by metre; immutable."""

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
        """The metres to look at, the route's ends left out."""
        return [
            float(at) for at in range(int(MARGIN) + STEP, int(self.route.length - MARGIN), STEP)
        ]

    def room(self, at: float) -> tuple[float, float]:
        """Return the metres to the junction behind and to the one ahead."""
        return float(self._before[int(at)]), float(self._after[int(at)])

    def limit(self, at: float) -> float:
        """Return the ego's speed limit, m/s."""
        return float(np.interp(at, self.route.along, self.route.speed_limits))

    def apart(self, one: float, other: float) -> float:
        """Return how far two places of the route are apart in a straight line, metres."""
        route = self.route
        x, y = (np.interp((one, other), route.along, column) for column in route.points.T)
        return float(np.hypot(x[1] - x[0], y[1] - y[0]))

    def span(self, at: float) -> LaneSpan:
        """Return the stretch of lane."""
        spans = self.route.lanes
        return next((span for span in spans if span.start <= at < span.end), spans[-1])

    def lane(self, at: float) -> Lane:
        """Return the lane."""
        return self.town.lanes[self.span(at).lane]

    def keeps_lane(self, start: float, end: float) -> bool:
        """Tell whether the route changes no lane on a stretch."""
        changes = self.route.lane_changes
        return all(change.end < start or change.start > end for change in changes)

    def is_straight(self, start: float, end: float) -> bool:
        """Tell whether the route goes straight on on a stretch."""
        route = self.route
        part = route.headings[(route.along >= start) & (route.along <= end)]
        return bool(len(part)) and float(part.max() - part.min()) < STRAIGHT

    def is_kerb(self, lane: Lane) -> bool:
        """Tell whether a lane is the rightmost of its road."""
        return lane.junction is None and lane.right is None and not lane.acceleration

    def sides(self, lane: Lane) -> tuple[int, ...]:
        """Return the sides from which one may step out: the left one across one lane at most."""
        alone = lane.left is None and not self._on_ring(lane)
        return (-1, 1) if alone and self.has_oncoming(lane) else (-1,)

    def has_oncoming(self, lane: Lane) -> bool:
        """Tell whether exactly one lane leads the other way beside a lane."""
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

    def run_to(self, at: float) -> float:
        """Return the metres that the lane at an arc length leads there straight on, from before."""
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
