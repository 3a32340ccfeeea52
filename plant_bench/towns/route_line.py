"""Computes the centre line of a route with smooth lane changes, one point per metre."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import arc_lengths, curvatures, resample
from plant_bench.towns.route_lanes import ChangeSpan, LanePlan, change_spans, lanes_between
from plant_bench.world.route import LaneChange, LaneSpan
from plant_bench.world.town import Lane, Town

SPACING = 1.0  # m between the points of a route
FINE = 0.25  # m between the points during smoothing
SMOOTHING = 0.7  # m: standard deviation of the smoothing along the line
SMOOTHING_MOST = 0.14  # m: largest displacement of a point by smoothing
CURVE_WINDOW = 5  # points over which curvature is averaged
LATERAL_ACCELERATION = 3.0  # m/s2: maximum in curves
SLOWEST = 3.0  # m/s: lowest speed limit in curves


@dataclass(frozen=True, eq=False)
class RouteLine:
    """The centre line of a route.

    Attributes:
        points: x, y, z every metre, rounded as in the files.
        spans: The lanes in order, including those inside junctions.
        changes: The lane changes in order.
    """

    points: Float[np.ndarray, "points 3"]
    spans: tuple[LaneSpan, ...]
    changes: tuple[LaneChange, ...]

    def speed_limits(self, town: Town) -> Float[np.ndarray, " points"]:
        """Return the speed limit at each point, m/s: posted, or less where curvature demands it."""
        bend = np.abs(curvatures(self.points[:, :2]))
        window = np.ones(CURVE_WINDOW) / CURVE_WINDOW
        bend = np.convolve(np.pad(bend, CURVE_WINDOW // 2, mode="edge"), window, mode="valid")
        curve_speed = np.sqrt(LATERAL_ACCELERATION / np.maximum(bend, 1e-6))
        ends = [span.end for span in self.spans]
        at = np.minimum(np.searchsorted(ends, arc_lengths(self.points[:, :2])), len(ends) - 1)
        posted = np.array([town.lanes[span.lane].speed_limit for span in self.spans])[at]
        return np.round(np.minimum(posted, np.maximum(curve_speed, SLOWEST)), 2)


@dataclass
class _Tracer:
    """Builds the line before smoothing, with the positions of lanes and lane changes; mutable."""

    town: Town
    pieces: list[np.ndarray] = field(default_factory=list)
    length: float = 0.0
    spans: list[tuple[str, float, float]] = field(default_factory=list)
    changes: list[tuple[float, float, str]] = field(default_factory=list)

    def follow(self, lane: Lane, start: float, end: float) -> None:
        """Append a lane from one arc length to another."""
        begin = self.length
        if end - start > 1e-3:
            inside = (lane.along > start) & (lane.along < end)
            at = np.concatenate(([start], lane.along[inside], [end]))
            self._draw(_on_lane(lane, at))
        self._note(lane, begin)

    def change(self, lane: Lane, other: Lane, span: ChangeSpan) -> float:
        """Append a lane change; return the arc length on the other lane at which it ends."""
        begin = self.length
        share = np.linspace(0.0, 1.0, 2 + int((span.end - span.start) / FINE))
        here = _on_lane(lane, span.start + share * (span.end - span.start))
        places = _project(here[:, :2], other)
        across = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        self._draw(here + across[:, None] * (_on_lane(other, places) - here))
        self._note(lane, begin)
        direction = "left" if lane.left == other.id else "right"
        self.changes.append((begin, self.length, direction))
        return float(places[-1])

    def _draw(self, points: np.ndarray) -> None:
        if self.pieces:
            points = np.concatenate((self.pieces[-1][-1:], points))
        self.length += float(arc_lengths(points[:, :2])[-1])
        self.pieces.append(points)

    def _note(self, lane: Lane, begin: float) -> None:
        if self.spans and self.spans[-1][0] == lane.id:
            begin = self.spans.pop()[1]
        self.spans.append((lane.id, begin, self.length))


@dataclass(frozen=True, eq=False)
class LaneStep:
    """A lane to follow to its end or to a lane change.

    Attributes:
        lane: The lane.
        change: The stretch of the lane change, metres; None to follow the lane to its end.
        other: The target lane of the lane change.
    """

    lane: Lane
    change: ChangeSpan | None = None
    other: Lane | None = None


def trace_steps(town: Town, steps: Sequence[LaneStep], *, start: float, end: float) -> RouteLine:
    """Compute the line along lanes and lane changes with known positions.

    Args:
        town: The town.
        steps: The lanes in order; a lane change is followed by its target lane.
        start: Arc length of the start on the first lane, metres.
        end: Arc length of the end on the last lane, metres.
    """
    tracer = _Tracer(town)
    at = start
    for step in steps[:-1]:
        if step.change is None or step.other is None:
            tracer.follow(step.lane, at, step.lane.length)
            at = 0.0
            continue
        span = ChangeSpan(max(step.change.start, at), max(step.change.end, at + 1.0))
        tracer.follow(step.lane, at, span.start)
        at = tracer.change(step.lane, step.other, span)
    tracer.follow(steps[-1].lane, at, max(end, at))
    return _finish(tracer)


def trace_line(town: Town, plan: LanePlan, start: float, end: float) -> RouteLine:
    """Compute the line of a lane plan.

    Args:
        town: The town.
        plan: The lane plan.
        start: Arc length of the start on the first edge's lane, metres.
        end: Arc length of the end on the last edge's lane, metres.
    """
    tracer = _Tracer(town)
    at = start
    for index, (entered, left) in enumerate(zip(plan.entered, plan.left, strict=True)):
        lane = town.lanes[entered]
        count = lanes_between(town, entered, left)
        for _ in range(abs(count)):
            lane, at = _change_once(tracer, lane, at, plan.entered[index], count)
        if index == len(plan.edges) - 1:
            tracer.follow(lane, at, end)
            break
        tracer.follow(lane, at, lane.length)
        for via in plan.links[index].via:
            tracer.follow(town.lanes[via], 0.0, town.lanes[via].length)
        at = 0.0
    return _finish(tracer)


def _change_once(
    tracer: _Tracer, lane: Lane, at: float, entered: str, count: int
) -> tuple[Lane, float]:
    """Append the next lane change of an edge; return the target lane and the arc length on it."""
    town = tracer.town
    done = abs(lanes_between(town, entered, lane.id))
    spans = change_spans(town.lanes[entered], abs(count)) or []
    other = town.lanes[str(lane.left if count > 0 else lane.right)]
    tracer.follow(lane, at, spans[done].start)
    return other, tracer.change(lane, other, spans[done])


def _finish(tracer: _Tracer) -> RouteLine:
    raw = np.concatenate(tracer.pieces)
    keep = np.concatenate(([True], np.hypot(*np.diff(raw[:, :2], axis=0).T) > 1e-6))
    fine = resample(raw[keep], FINE)
    raw_along = np.linspace(0.0, tracer.length, len(fine))
    fine = _smooth(fine)
    fine_along = arc_lengths(fine[:, :2])
    points = np.round(resample(fine, SPACING), 3)
    along = arc_lengths(points[:, :2])
    even = np.linspace(0.0, fine_along[-1], len(points))

    def place(raw_place: float) -> float:
        smooth_place = np.interp(raw_place, raw_along, fine_along)
        return round(float(np.interp(smooth_place, even, along)), 3)

    spans = [LaneSpan(lane, place(begin), place(end)) for lane, begin, end in tracer.spans]
    changes = [LaneChange(place(begin), place(end), side) for begin, end, side in tracer.changes]
    return RouteLine(points, tuple(spans), tuple(changes))


def _smooth(points: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
    """Smooth the line with a Gaussian; the ends stay, points move by at most `SMOOTHING_MOST`."""
    reach = round(3.0 * SMOOTHING / FINE)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) * FINE / SMOOTHING) ** 2)
    weights /= weights.sum()
    if len(points) <= reach:
        return points
    head = 2.0 * points[0] - points[reach:0:-1]
    tail = 2.0 * points[-1] - points[-2 : -reach - 2 : -1]
    padded = np.concatenate((head, points, tail))
    blurred = np.stack([np.convolve(c, weights, mode="valid") for c in padded.T], axis=1)
    moved = blurred - points
    distance = np.hypot(moved[:, 0], moved[:, 1])
    return points + moved * np.minimum(1.0, SMOOTHING_MOST / np.maximum(distance, 1e-9))[:, None]


def _on_lane(lane: Lane, at: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(at, lane.along, column) for column in lane.points.T], axis=1)


def _project(points: Float[np.ndarray, "points 2"], lane: Lane) -> Float[np.ndarray, " points"]:
    """Return the arc length of each point's projection on the lane."""
    begin, step = lane.points[:-1, :2], np.diff(lane.points[:, :2], axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-12)
    offset = points[:, None] - begin
    share = np.clip((offset * step).sum(axis=2) / square, 0.0, 1.0)
    gap = offset - share[..., None] * step
    nearest = np.argmin((gap**2).sum(axis=2), axis=1)
    rows = np.arange(len(points))
    return lane.along[nearest] + share[rows, nearest] * np.sqrt(square[nearest])
