"""Checks that a kinematic bicycle model can follow every lane and every turn of a town."""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plant_bench.towns.street_shapes import Shape, arc_lengths, join, resample, tightest_radius
from plant_bench.world.town import Link, Town

Indices = NDArray[np.int_]

WHEELBASE_M = 2.86
STEERING_MAX = float(np.radians(35))
LOOK_AHEAD_M = 3.5
LATERAL_ACCELERATION = 3.0  # m/s2
STEP_S = 0.05
PATH_STEP_M = 0.25
RUN_IN_M = 25.0  # length of lane before and after a turn
PIECE_MAX_M = 120.0

ERROR_MAX_M = 0.35
RADIUS_MIN_M = 4.5
GAP_MAX_M = 0.1


@dataclass(frozen=True)
class PathDrive:
    """Result of following one path.

    Attributes:
        path: Name of the path: its lanes, or a lane and an arc length.
        radius: Smallest radius of the path, metres.
        gap: Largest gap between its lanes, metres.
        error: Largest lateral deviation of the bicycle model, metres.
    """

    path: str
    radius: float
    gap: float
    error: float


def drive_all(town: Town) -> list[PathDrive]:
    """Follow every path through a junction, with some lane before and after it, and every lane."""
    paths = [(f"{link.source}->{link.target}", *_turn_path(town, link)) for link in town.links]
    for lane in town.lanes.values():
        if lane.junction is None and lane.length > 2 * RUN_IN_M:
            for start in np.arange(0, lane.length, PIECE_MAX_M):
                piece = _cut(lane.points[:, :2], float(start), float(start) + PIECE_MAX_M + 5)
                if len(piece) > 1 and arc_lengths(piece)[-1] > 8:
                    limit = lane.speed_limit
                    paths.append((f"{lane.id}@{start:.0f}", piece, 0.0, limit))
    radii = np.array([tightest_radius(shape) for _, shape, _, _ in paths])
    limits = np.array([limit for *_, limit in paths])
    speeds = np.minimum(limits, np.sqrt(LATERAL_ACCELERATION * radii))
    errors = _pursue([shape for _, shape, _, _ in paths], speeds)
    return [
        PathDrive(name, float(radius), gap, float(error))
        for (name, _, gap, _), radius, error in zip(paths, radii, errors, strict=True)
    ]


def find_undrivable(town: Town) -> list[str]:
    """Describe every path that has a gap, is too tight, or cannot be followed by the model."""
    faults = []
    for drive in drive_all(town):
        if drive.gap > GAP_MAX_M:
            faults.append(f"{drive.path} has a gap of {drive.gap:.2f} m")
        if drive.radius < RADIUS_MIN_M:
            faults.append(f"{drive.path} bends with a radius of {drive.radius:.1f} m")
        if drive.error > ERROR_MAX_M:
            faults.append(f"{drive.path} cannot be followed: deviation of {drive.error:.2f} m")
    return faults


def _turn_path(town: Town, link: Link) -> tuple[Shape, float, float]:
    """The path of a link (n 2), the largest gap between its lanes, its lowest speed limit."""
    lanes = [town.lanes[name] for name in (link.source, *link.via, link.target)]
    shapes = [lane.points[:, :2] for lane in lanes]
    pairs = itertools.pairwise(shapes)
    gap = max(float(np.hypot(*(b[0] - a[-1]))) for a, b in pairs)
    shapes[0] = _cut(shapes[0], lanes[0].length - RUN_IN_M, lanes[0].length)
    shapes[-1] = _cut(shapes[-1], 0.0, RUN_IN_M)
    return join(shapes), gap, min(lane.speed_limit for lane in lanes)


def _cut(shape: Shape, begin: float, end: float) -> Shape:
    along = arc_lengths(shape)
    begin, end = max(0.0, begin), min(float(along[-1]), end)
    inner = shape[(along > begin) & (along < end)]
    ends = [[np.interp(at, along, column) for column in shape.T] for at in (begin, end)]
    return join([np.array(ends[:1]), inner, np.array(ends[1:])])


def _pursue(shapes: list[Shape], speeds: Shape) -> Shape:
    """Follow each path by pure pursuit; return the largest lateral deviation of each (n)."""
    fine = [resample(shape, PATH_STEP_M) for shape in shapes]
    counts = np.array([len(shape) for shape in fine])
    padded = np.stack([np.pad(s, ((0, counts.max() - len(s)), (0, 0)), mode="edge") for s in fine])
    rows = np.arange(len(fine))
    ahead = round(LOOK_AHEAD_M / PATH_STEP_M)
    window = np.arange(-4, 16)
    xy, at = padded[:, 0].copy(), np.zeros(len(fine), dtype=int)
    first = padded[:, 1] - padded[:, 0]
    heading = np.arctan2(first[:, 1], first[:, 0])
    worst, running = np.zeros(len(fine)), np.ones(len(fine), dtype=bool)
    for _ in range(int(np.ceil((counts * PATH_STEP_M / speeds).max() / STEP_S))):
        near = np.clip(at[:, None] + window, 0, counts[:, None] - 1)
        distance = np.hypot(*np.moveaxis(padded[rows[:, None], near] - xy[:, None], -1, 0))
        best = distance.argmin(axis=1)
        at = near[rows, best]
        running &= at + ahead < counts
        if not running.any():
            break
        worst = np.where(running, np.maximum(worst, _across(padded, at, xy, rows)), worst)
        goal = padded[rows, np.minimum(at + ahead, counts - 1)] - xy
        reach = np.maximum(np.hypot(goal[:, 0], goal[:, 1]), 0.1)
        bearing = np.arctan2(goal[:, 1], goal[:, 0]) - heading
        steering = np.arctan(2 * WHEELBASE_M * np.sin(bearing) / reach)
        steering = np.clip(steering, -STEERING_MAX, STEERING_MAX)
        heading = heading + speeds / WHEELBASE_M * np.tan(steering) * STEP_S
        xy = xy + (speeds * STEP_S)[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    return worst


def _across(padded: Shape, at: Indices, xy: Shape, rows: Indices) -> Shape:
    """Return the lateral distance of each bicycle from its path."""
    last = padded.shape[1] - 1
    tangent = padded[rows, np.minimum(at + 1, last)] - padded[rows, np.maximum(at - 1, 0)]
    tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-9)[:, None]
    away = xy - padded[rows, at]
    return np.abs(tangent[:, 0] * away[:, 1] - tangent[:, 1] * away[:, 0])
