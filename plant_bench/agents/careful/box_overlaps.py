"""Compiled overlap tests of oriented boxes for the careful driver.

Results equal those of `geometry.box.overlap` exactly.
"""

import math

import numpy as np

from plant_bench.jit import (
    BOOL_1D,
    F32_1D,
    F32_2D,
    F64,
    F64_1D,
    F64_2D,
    F64_3D,
    compiled,
)


@compiled(F64, F64, F64, F64, F64, F64, F64, F64, F64, F64)
def overlapping(x_a, y_a, yaw_a, length_a, width_a, x_b, y_b, yaw_b, length_b, width_b):
    """Return whether two boxes overlap (separating axes; touching is no overlap)."""
    dx, dy, turn = x_b - x_a, y_b - y_a, yaw_b - yaw_a
    cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
    long_a, wide_a, long_b, wide_b = 0.5 * length_a, 0.5 * width_a, 0.5 * length_b, 0.5 * width_b
    cos_a, sin_a = math.cos(yaw_a), math.sin(yaw_a)
    if abs(dx * cos_a + dy * sin_a) >= long_a + long_b * cos + wide_b * sin:
        return False
    if abs(dy * cos_a - dx * sin_a) >= wide_a + long_b * sin + wide_b * cos:
        return False
    cos_b, sin_b = math.cos(yaw_b), math.sin(yaw_b)
    if abs(dx * cos_b + dy * sin_b) >= long_b + long_a * cos + wide_a * sin:
        return False
    return abs(dy * cos_b - dx * sin_b) < wide_b + long_a * sin + wide_a * cos


@compiled(F64_1D, F64_1D, F32_2D, F32_2D, F32_1D, F64)
def stationary_overlaps(pose, extent, poses, extents, speeds, standing):
    """Return which boxes are stationary, overlap a box and have their centres behind its front.

    Args:
        pose: The box's pose, (3).
        extent: The box's extent, (2).
        poses: The other boxes' poses, (boxes, 3).
        extents: The other boxes' extents, (boxes, 2).
        speeds: The other boxes' speeds, (boxes), m/s.
        standing: Speed below which they are stationary, m/s.

    Returns:
        Mask, (boxes).
    """
    found = np.zeros(len(poses), np.bool_)
    radius = np.float32(0.5 * math.hypot(extent[0], extent[1]))
    front = np.float32(0.5 * extent[0])
    x, y = np.float32(pose[0]), np.float32(pose[1])
    cos, sin = np.float32(math.cos(pose[2])), np.float32(math.sin(pose[2]))
    for row in range(len(poses)):
        if not speeds[row] < np.float32(standing):
            continue
        reach = radius + np.float32(0.5) * (extents[row, 0] + extents[row, 1])
        dx, dy = poses[row, 0] - x, poses[row, 1] - y
        if dx * dx + dy * dy < reach * reach and cos * dx + sin * dy < front:
            found[row] = overlapping(
                pose[0], pose[1], pose[2], extent[0], extent[1],
                poses[row, 0], poses[row, 1], poses[row, 2], extents[row, 0], extents[row, 1],
            )  # fmt: skip
    return found


@compiled(F64_1D, F64_1D, F64_3D, F64_2D, F64_1D, BOOL_1D, F64)
def same_direction_overlaps(pose, extent, poses, lengths, widths, candidates, min_cosine):
    """Return which predicted boxes overlap a box at any step while heading the same way.

    Args:
        pose: The box's pose, (3).
        extent: The box's extent, (2).
        poses: The other boxes' poses, (boxes, steps, 3).
        lengths: The other boxes' lengths, (boxes, steps).
        widths: The other boxes' widths, (boxes).
        candidates: Mask of the boxes to test, (boxes); the result is False for the rest.
        min_cosine: Cosine of the relative heading above which they head the same way.

    Returns:
        Mask, (boxes).
    """
    found = np.zeros(len(poses), np.bool_)
    radius = 0.5 * math.hypot(extent[0], extent[1])
    for row in range(len(poses)):
        if not candidates[row]:
            continue
        for step in range(poses.shape[1]):
            x, y, yaw = poses[row, step]
            dx, dy = x - pose[0], y - pose[1]
            reach = radius + 0.5 * (lengths[row, step] + widths[row])
            if dx * dx + dy * dy < reach * reach and math.cos(yaw - pose[2]) > min_cosine:
                found[row] = overlapping(
                    pose[0], pose[1], pose[2], extent[0], extent[1],
                    x, y, yaw, lengths[row, step], widths[row],
                )  # fmt: skip
                if found[row]:
                    break
    return found


@compiled(F64_3D, F64_1D, F64_3D, F64_2D, F64_1D, F64_1D, F64_1D, F64)
def first_overlaps(egos, extent, poses, lengths, widths, margins, shares, aside):
    """Return each ego rollout's first overlap; of several at that step, with the nearest box.

    Args:
        egos: The ego's poses, (choices, steps, 3).
        extent: The ego's extent, (2).
        poses: The other boxes' poses, (boxes, steps, 3).
        lengths: The other boxes' lengths, (boxes, steps).
        widths: The other boxes' widths, (boxes).
        margins: Margins in front of and behind the other boxes, (boxes), metres.
        shares: Factor on the margins, (boxes).
        aside: Margin on each side of the other boxes, metres.

    Returns:
        Steps and box rows, both (choices); -1 for none.
    """
    steps, boxes = np.full(len(egos), -1), np.full(len(egos), -1)
    size = extent[0] + extent[1]
    for choice in range(len(egos)):
        for step in range(egos.shape[1]):
            x, y, yaw = egos[choice, step]
            least = np.inf
            for row in range(len(poses)):
                dx, dy = x - poses[row, step, 0], y - poses[row, step, 1]
                square = dx * dx + dy * dy
                length, width = lengths[row, step] + 2 * margins[row], widths[row] + 2 * aside
                reach = 0.5 * (size + length + width)
                if not square < reach * reach or not square < least:
                    continue
                length = lengths[row, step] + 2 * margins[row] * shares[row]
                width = widths[row] + 2 * aside * shares[row]
                if overlapping(
                    x, y, yaw, extent[0], extent[1],
                    poses[row, step, 0], poses[row, step, 1], poses[row, step, 2], length, width,
                ):  # fmt: skip
                    least, steps[choice], boxes[choice] = square, step, row
            if boxes[choice] >= 0:
                break
    return steps, boxes
