"""Geometry of streets: smooth curves through poses, rounded corners and offset curves.

All shapes are arrays of points (n 2) in metres; headings are radians counter-clockwise from +x.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plant_bench.geometry.pose import wrap_angle

Shape = NDArray[np.float64]

POINT_SPACING_M = 1.5
STRAIGHT_TOLERANCE_M = 0.004


@dataclass(frozen=True)
class Pose:
    """A point of a street and the street's heading there."""

    x: float
    y: float
    heading: float

    @property
    def point(self) -> Shape:
        """The position as an array (2)."""
        return np.array([self.x, self.y])

    @property
    def direction(self) -> Shape:
        """The unit vector of the heading (2)."""
        return np.array([np.cos(self.heading), np.sin(self.heading)])

    def ahead(self, distance: float) -> "Pose":
        """The pose moved straight on by `distance` metres (backwards if negative)."""
        x, y = self.point + distance * self.direction
        return Pose(float(x), float(y), self.heading)

    def beside(self, left: float) -> "Pose":
        """The pose moved sideways by `left` metres (to the right if negative)."""
        return Pose(
            self.x - left * float(np.sin(self.heading)),
            self.y + left * float(np.cos(self.heading)),
            self.heading,
        )

    def reversed(self) -> "Pose":
        """The same position with the opposite heading."""
        return Pose(self.x, self.y, self.heading + np.pi)


def curve_between(start: Pose, end: Pose, spacing: float = POINT_SPACING_M) -> Shape:
    """Return a smooth curve between two poses: nearly an arc where possible, else an S-curve."""
    chord = end.point - start.point
    length = float(np.hypot(*chord))
    bearing = float(np.arctan2(chord[1], chord[0]))
    leave, arrive = wrap_angle(start.heading - bearing), wrap_angle(end.heading - bearing)
    if leave * arrive < 0:
        handle = length / (3 * np.cos((abs(leave) + abs(arrive)) / 4) ** 2)
    else:
        handle = 0.45 * length
    controls = (
        start.point,
        start.point + handle * start.direction,
        end.point - handle * end.direction,
        end.point,
    )
    t = np.linspace(0.0, 1.0, max(2, int(np.ceil(1.1 * length / spacing)) + 1))[:, None]
    weights = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3)
    return np.sum([w * c for w, c in zip(weights, controls, strict=True)], axis=0)


def curve_through(poses: list[Pose], spacing: float = POINT_SPACING_M) -> Shape:
    """Return a smooth curve through poses, without redundant points on straight parts."""
    pieces = [curve_between(a, b, spacing) for a, b in itertools.pairwise(poses)]
    return thin_out(join(pieces))


def fillet(points: list[tuple[float, float]], radius: float) -> Shape:
    """Return a polyline with its inner corners rounded to `radius` metres.

    The radius is smaller where a segment is too short for it.
    """
    corners = np.asarray(points, dtype=float)
    legs = np.hypot(*np.diff(corners, axis=0).T)
    poses = [_pose_at(corners[0], corners[1])]
    for before, corner, after, short in zip(
        corners, corners[1:], corners[2:], np.minimum(legs[:-1], legs[1:]), strict=False
    ):
        arriving, leaving = _pose_at(corner, 2 * corner - before), _pose_at(corner, after)
        turn = abs(wrap_angle(leaving.heading - arriving.heading))
        if turn < 1e-3:
            continue
        cut = min(radius * float(np.tan(turn / 2)), 0.49 * float(short))
        poses += [arriving.ahead(-cut), leaving.ahead(cut)]
    last = _pose_at(corners[-2], corners[-1])
    poses.append(Pose(float(corners[-1][0]), float(corners[-1][1]), last.heading))
    return curve_through(poses)


def corner(before: Pose, after: Pose, radius: float) -> Shape:
    """Return a straight line from one pose, a rounded corner, and a straight line into another.

    If the two lines do not intersect ahead, return one smooth curve.
    """
    normal = np.array([-after.direction[1], after.direction[0]])
    closing = float(normal @ before.direction)
    if abs(closing) > 0.05:
        run = float(normal @ (after.point - before.point)) / closing
        intersection = before.ahead(run)
        rest = float((after.point - intersection.point) @ after.direction)
        if run > 0 and rest > 0:
            reach = abs(float(np.tan(wrap_angle(after.heading - before.heading) / 2)))
            largest = min(run, rest) / max(reach, 1e-6)
            return _round(before, after, intersection, min(radius, 0.98 * largest), reach)
    return curve_through([before, after])


def _round(before: Pose, after: Pose, intersection: Pose, radius: float, reach: float) -> Shape:
    leave = Pose(intersection.x, intersection.y, after.heading)
    return curve_through(
        [before, intersection.ahead(-radius * reach), leave.ahead(radius * reach), after]
    )


def offset(shape: Shape, left: float | Shape) -> Shape:
    """Return the curve moved to the left by `left` metres, one value or one per point (n)."""
    tangent = np.gradient(shape[:, :2], axis=0)
    tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-9)[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    moved = shape.copy()
    moved[:, :2] += normal * np.broadcast_to(left, (len(shape),))[:, None]
    return moved


def join(pieces: list[Shape]) -> Shape:
    """Concatenate pieces to one line, without repeated points."""
    line = np.concatenate(pieces)
    keep = np.r_[True, np.hypot(*np.diff(line, axis=0)[:, :2].T) > 1e-6]
    return line[keep]


def arc_lengths(shape: Shape) -> Shape:
    """Return the arc length of each point (n), in the plane."""
    return np.r_[0.0, np.cumsum(np.hypot(*np.diff(shape[:, :2], axis=0).T))]


def resample(shape: Shape, spacing: float) -> Shape:
    """Return equidistant points of the line, at most `spacing` metres apart."""
    along = arc_lengths(shape)
    count = max(2, int(np.ceil(along[-1] / spacing)) + 1)
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, column) for column in shape.T], axis=1)


def start_pose(shape: Shape) -> Pose:
    """Return the pose at the start of the line."""
    return _pose_at(shape[0], shape[1])


def end_pose(shape: Shape) -> Pose:
    """Return the pose at the end of the line."""
    last = _pose_at(shape[-2], shape[-1])
    return Pose(float(shape[-1][0]), float(shape[-1][1]), last.heading)


def thin_out(shape: Shape) -> Shape:
    """Remove points that are within `STRAIGHT_TOLERANCE_M` of a line between kept points."""
    kept = [0]
    for index in range(1, len(shape) - 1):
        first = shape[kept[-1]]
        between = shape[kept[-1] + 1 : index + 1] - first
        straight = shape[index + 1] - first
        straight = straight / np.linalg.norm(straight)
        across = between - np.outer(between @ straight, straight)
        if np.linalg.norm(across, axis=1).max() > STRAIGHT_TOLERANCE_M:
            kept.append(index)
    return shape[[*kept, len(shape) - 1]]


def tightest_radius(shape: Shape, window: float = 3.0) -> float:
    """Return the smallest radius of the line, from changes of heading over `window` metres."""
    fine = resample(shape[:, :2], window / 6)
    heading = np.unwrap(np.arctan2(*np.diff(fine, axis=0).T[::-1]))
    if len(heading) <= 6:
        return float("inf")
    turned = np.abs(heading[6:] - heading[:-6]).max()
    return float(window / max(turned, 1e-9))


def _pose_at(here: Shape, towards: Shape) -> Pose:
    heading = float(np.arctan2(towards[1] - here[1], towards[0] - here[0]))
    return Pose(float(here[0]), float(here[1]), heading)
