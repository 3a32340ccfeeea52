"""Loops over pairs of boxes: which overlap, and which first.

As `geometry.box.overlap`, to the bit; only what a careful driver asks for is worked out.
"""

import math

import numpy as np

from plant_bench.jit import (
    FLAGS,
    REAL,
    REALS,
    REALS_2D,
    REALS_3D,
    SINGLES,
    SINGLES_2D,
    compiled,
)


@compiled(REAL, REAL, REAL, REAL, REAL, REAL, REAL, REAL, REAL, REAL)
def overlapping(x_a, y_a, yaw_a, length_a, width_a, x_b, y_b, yaw_b, length_b, width_b):
    """Tell whether two boxes overlap (separating axes; touching is no overlap)."""
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


@compiled(REALS, REALS, SINGLES_2D, SINGLES_2D, SINGLES, REAL)
def standing_in_touch(pose, extent, poses, extents, speeds, standing):
    """Tell which boxes stand, overlap one box and have their centres behind its front.

    Args:
        pose: Of the one, (3).
        extent: Of the one, (2).
        poses: Of the others, (boxes, 3).
        extents: Of the others, (boxes, 2).
        speeds: Of the others, m/s.
        standing: m/s below which they stand.

    Returns:
        (boxes) flags.
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


@compiled(REALS, REALS, REALS_3D, REALS_2D, REALS, FLAGS, REAL)
def meets_going_its_way(pose, extent, poses, lengths, widths, asked, same_way):
    """Tell which boxes ever overlap one box while they head as it does.

    Args:
        pose: Of the one, (3).
        extent: Of the one, (2).
        poses: Of the others, (boxes, steps, 3).
        lengths: Of the others, (boxes, steps).
        widths: Of the others.
        asked: Which of them are looked at; the rest do not.
        same_way: Cosine of the angle up to which they head as it does.

    Returns:
        (boxes) flags.
    """
    found = np.zeros(len(poses), np.bool_)
    radius = 0.5 * math.hypot(extent[0], extent[1])
    for row in range(len(poses)):
        if not asked[row]:
            continue
        for step in range(poses.shape[1]):
            x, y, yaw = poses[row, step]
            dx, dy = x - pose[0], y - pose[1]
            reach = radius + 0.5 * (lengths[row, step] + widths[row])
            if dx * dx + dy * dy < reach * reach and math.cos(yaw - pose[2]) > same_way:
                found[row] = overlapping(
                    pose[0], pose[1], pose[2], extent[0], extent[1],
                    x, y, yaw, lengths[row, step], widths[row],
                )  # fmt: skip
                if found[row]:
                    break
    return found


@compiled(REALS_3D, REALS, REALS_3D, REALS_2D, REALS, REALS, REALS, REAL)
def first_overlaps(egos, extent, poses, lengths, widths, margins, shares, aside):
    """Return for each row of poses of one box the first overlap; of several, the nearest box.

    Args:
        egos: Its poses, (choices, steps, 3).
        extent: Of it, (2).
        poses: Of the others, (boxes, steps, 3).
        lengths: Of the others, (boxes, steps).
        widths: Of the others.
        margins: In front of and behind the others, metres.
        shares: Of the margins that count.
        aside: Margin on each side of the others, metres.

    Returns:
        (choices) steps and (choices) boxes; -1 for none.
    """
    steps, who = np.full(len(egos), -1), np.full(len(egos), -1)
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
                    least, steps[choice], who[choice] = square, step, row
            if who[choice] >= 0:
                break
    return steps, who
