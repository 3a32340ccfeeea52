"""Polylines: arc length, projection, resampling, curvature."""

import math
from bisect import bisect_right
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float


def arc_lengths(points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, " points"]:
    """Return the arc length of each point, starting at 0."""
    steps = np.hypot(np.diff(points[:, 0]), np.diff(points[:, 1]))
    return np.concatenate(([0.0], np.cumsum(steps)))


def without_repeats(points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "kept 2"]:
    """Return the points without those within a millimetre of the previous one."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    return points[np.concatenate(([True], steps > 1e-3))]


def headings(points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, " points"]:
    """Return the unwrapped heading of the segment at each point; the last one is repeated."""
    delta = np.diff(points, axis=0)
    yaw = np.unwrap(np.arctan2(delta[:, 1], delta[:, 0]))
    return np.concatenate((yaw, yaw[-1:]))


def resample(
    points: Float[np.ndarray, "points dims"], spacing: float
) -> Float[np.ndarray, "samples dims"]:
    """Return points every `spacing` metres in the plane, including both ends.

    The spacing is adjusted slightly, to divide the length evenly.
    """
    along = arc_lengths(points[:, :2])
    count = max(1, round(along[-1] / spacing))
    at = np.linspace(0.0, along[-1], count + 1)
    return np.stack([np.interp(at, along, column) for column in points.T], axis=1)


def curvatures(points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, " points"]:
    """Return the signed curvature at each point in 1/m, positive to the left.

    Computed by central differences; the two ends repeat their neighbour's value.
    """
    if len(points) < 3:
        return np.zeros(len(points))
    before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    dot = np.einsum("ij,ij->i", before, after)
    length = 0.5 * (np.hypot(*before.T) + np.hypot(*after.T))
    inner = np.arctan2(cross, dot) / np.maximum(length, 1e-9)
    return np.concatenate((inner[:1], inner, inner[-1:]))


def value_at(at: float, along: Sequence[float], values: Sequence[float]) -> float:
    """Return the value at an arc length by linear interpolation; equals `numpy.interp` exactly.

    More than twice as fast as numpy for a single position; constant beyond the ends.

    Args:
        at: Arc length to interpolate at.
        along: Arc length of each point, ascending.
        values: Value at each point.
    """
    after = bisect_right(along, at)
    if after == 0:
        return values[0]
    if after == len(along) or along[after - 1] == at:
        return values[after - 1]
    before = after - 1
    slope = (values[after] - values[before]) / (along[after] - along[before])
    return slope * (at - along[before]) + values[before]


class Cursor:
    """A position on a polyline, which `advance` only moves forward; mutable.

    The search is plain Python, since it runs at every tick and usually visits one or two segments,
    which is faster than any numpy call.

    Args:
        points: The polyline, with any spacing.
    """

    def __init__(self, points: Float[np.ndarray, "points 2"]) -> None:
        self._x = points[:, 0].tolist()
        self._y = points[:, 1].tolist()
        self._along = arc_lengths(points).tolist()
        self.index = 0
        self.progress = 0.0
        self.offset = 0.0

    @property
    def length(self) -> float:
        """Length of the line, metres."""
        return self._along[-1]

    @property
    def heading(self) -> float:
        """Heading of the current segment, radians."""
        i = self.index
        return math.atan2(self._y[i + 1] - self._y[i], self._x[i + 1] - self._x[i])

    def place(self, at: float) -> None:
        """Move to an arc length, forward or backward."""
        at = min(max(at, 0.0), self.length)
        self.index = min(bisect_right(self._along, at) - 1, len(self._x) - 2)
        self.progress, self.offset = at, 0.0

    def advance(self, x: float, y: float, *, most: int = 8) -> None:
        """Move to the projection of a point, forward by at most `most` segments.

        Sets `progress`, the arc length, and `offset`, the lateral distance of the point from the
        line, positive to the left; both in metres.
        """
        last = len(self._x) - 2
        for _ in range(most + 1):
            i = self.index
            dx, dy = self._x[i + 1] - self._x[i], self._y[i + 1] - self._y[i]
            length = self._along[i + 1] - self._along[i]
            px, py = x - self._x[i], y - self._y[i]
            along = (px * dx + py * dy) / length
            if along > length and i < last:
                self.index = i + 1
                continue
            self.offset = (dx * py - dy * px) / length
            self.progress = max(self.progress, self._along[i] + min(max(along, 0.0), length))
            return
        self.progress = max(self.progress, self._along[self.index])


def distance_to(points: Float[np.ndarray, "points 2"], x: float, y: float) -> float:
    """Return the distance of (x, y) from the nearest point of the polyline."""
    return float(distances_to(points, np.array([[x, y]]))[0])


def distances_to(
    points: Float[np.ndarray, "points 2"], places: Float[np.ndarray, "places 2"]
) -> Float[np.ndarray, " places"]:
    """Return the distance of each place from the nearest point of the polyline."""
    start, delta = points[:-1], np.diff(points, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", delta, delta), 1e-12)
    dx, dy = places[:, 0, None] - start[:, 0], places[:, 1, None] - start[:, 1]
    share = np.clip((dx * delta[:, 0] + dy * delta[:, 1]) / square, 0, 1)
    dx, dy = dx - share * delta[:, 0], dy - share * delta[:, 1]
    return np.sqrt(np.min(dx * dx + dy * dy, axis=1))
