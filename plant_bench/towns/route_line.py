"""Computes the centre line of a route with smooth lane changes, one point per metre."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import arc_lengths, curvatures, resample
from plant_bench.towns.route_lanes import ChangeSpan, LanePlan, change_spans, lanes_between
from plant_bench.towns.street_shapes import offset
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


@dataclass(frozen=True)
class Drift:
    """A lane change that goes on beyond the edge's end, or begins before its start.

    Attributes:
        start: Where it begins, metres from the point at which the lanes are swapped.
        end: Where it ends, likewise; both are positive (after the swap) or both negative.
    """

    start: float
    end: float


@dataclass(frozen=True)
class _Swap:
    """A jump of the raw line to the adjacent lane, which a drift makes smooth.

    Attributes:
        piece: Index of the first piece on the new lane.
        at: Arc length of the jump, metres.
        offset: Lateral offset of the old lane from the new one, positive to the left, metres.
        drift: The extent of the lane change.
    """

    piece: int
    at: float
    offset: float
    drift: Drift


@dataclass
class _Tracer:
    """Builds the line before smoothing, with the positions of lanes and lane changes; mutable."""

    town: Town
    pieces: list[np.ndarray] = field(default_factory=list)
    starts: list[float] = field(default_factory=list)  # arc length at the start of each piece
    swaps: list[_Swap] = field(default_factory=list)
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

    def swap(self, lane: Lane, other: Lane, at: float, drift: Drift) -> float:
        """Go on on the adjacent lane; return the arc length on it."""
        here = _on_lane(lane, np.array([at]))
        place = float(_project(here[:, :2], other)[0])
        near = _on_lane(other, np.array([max(place - 0.5, 0.0), min(place + 0.5, other.length)]))
        dx, dy = near[1, :2] - near[0, :2]
        away = here[0, :2] - near.mean(axis=0)[:2]
        offset = float(dx * away[1] - dy * away[0]) / max(float(np.hypot(dx, dy)), 1e-9)
        self.swaps.append(_Swap(len(self.pieces), self.length, offset, drift))
        direction = "left" if lane.left == other.id else "right"
        begin, end = self.length + drift.start, self.length + drift.end
        self.changes.append((max(begin, 0.0), end, direction))
        return place

    def _draw(self, points: np.ndarray) -> None:
        swapped = bool(self.swaps) and self.swaps[-1].piece == len(self.pieces)
        if self.pieces and not swapped:
            points = np.concatenate((self.pieces[-1][-1:], points))
        self.starts.append(self.length)
        self.length += float(arc_lengths(points[:, :2])[-1])
        self.pieces.append(points)

    def line(self) -> np.ndarray:
        """Return the raw line, its lane changes beyond edges made smooth."""
        if not self.swaps:
            return np.concatenate(self.pieces)
        pieces = [resample(piece, FINE) if len(piece) > 1 else piece for piece in self.pieces]
        shifted = []
        for index, (piece, start) in enumerate(zip(pieces, self.starts, strict=True)):
            at = start + arc_lengths(piece[:, :2])
            left = sum((self._shift(swap, index, at) for swap in self.swaps), np.zeros(len(at)))
            shifted.append(offset(piece, left) if len(piece) > 1 and left.any() else piece)
        return np.concatenate(shifted)

    @staticmethod
    def _shift(swap: _Swap, piece: int, at: np.ndarray) -> np.ndarray:
        """Return by how much a swap moves points of a piece to the left, metres."""
        drift = swap.drift
        share = np.clip((at - swap.at - drift.start) / (drift.end - drift.start), 0.0, 1.0)
        across = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        if piece >= swap.piece:
            return swap.offset * (1.0 - across) if drift.end > 0.0 else np.zeros(len(at))
        return -swap.offset * across if drift.start < 0.0 else np.zeros(len(at))

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
        drift: How far the lane change reaches beyond the edge; the lanes are then swapped at the
            start of `change`. None for a lane change on the edge alone.
    """

    lane: Lane
    change: ChangeSpan | None = None
    other: Lane | None = None
    drift: Drift | None = None


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
        if step.drift is not None:
            place = max(step.change.start, at)
            tracer.follow(step.lane, at, place)
            at = tracer.swap(step.lane, step.other, place, step.drift)
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
    raw = tracer.line()
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
