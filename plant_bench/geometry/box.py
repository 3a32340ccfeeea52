"""Oriented boxes: a pose for the centre and an extent (length, width), full sizes in metres."""

import math

import numpy as np
from jaxtyping import Bool, Float

_ALONG, _ACROSS = np.array([0.5, -0.5, -0.5, 0.5]), np.array([0.5, 0.5, -0.5, -0.5])


def corners(
    poses: Float[np.ndarray, "boxes 3"], extents: Float[np.ndarray, "boxes 2"]
) -> Float[np.ndarray, "boxes 4 2"]:
    """Return the corners, counter-clockwise from front left."""
    cos, sin = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    along, across = extents[:, 0, None] * _ALONG, extents[:, 1, None] * _ACROSS
    found = np.empty((len(poses), 4, 2))
    found[..., 0] = poses[:, 0, None] + cos * along - sin * across
    found[..., 1] = poses[:, 1, None] + sin * along + cos * across
    return found


def overlap(
    poses_a: Float[np.ndarray, "pairs 3"],
    extents_a: Float[np.ndarray, "pairs 2"],
    poses_b: Float[np.ndarray, "pairs 3"],
    extents_b: Float[np.ndarray, "pairs 2"],
) -> Bool[np.ndarray, " pairs"]:
    """Return whether the boxes of each pair overlap (separating axes; touching does not count)."""
    dx, dy = poses_b[:, 0] - poses_a[:, 0], poses_b[:, 1] - poses_a[:, 1]
    turn = poses_b[:, 2] - poses_a[:, 2]
    cos, sin = np.abs(np.cos(turn)), np.abs(np.sin(turn))
    half_a, half_b = 0.5 * extents_a, 0.5 * extents_b
    cos_a, sin_a = np.cos(poses_a[:, 2]), np.sin(poses_a[:, 2])
    cos_b, sin_b = np.cos(poses_b[:, 2]), np.sin(poses_b[:, 2])
    apart = (
        np.abs(dx * cos_a + dy * sin_a) >= half_a[:, 0] + half_b[:, 0] * cos + half_b[:, 1] * sin
    )
    apart |= (
        np.abs(dy * cos_a - dx * sin_a) >= half_a[:, 1] + half_b[:, 0] * sin + half_b[:, 1] * cos
    )
    apart |= (
        np.abs(dx * cos_b + dy * sin_b) >= half_b[:, 0] + half_a[:, 0] * cos + half_a[:, 1] * sin
    )
    apart |= (
        np.abs(dy * cos_b - dx * sin_b) >= half_b[:, 1] + half_a[:, 0] * sin + half_a[:, 1] * cos
    )
    return ~apart


def overlap_one(
    pose: tuple[float, float, float],
    extent: tuple[float, float],
    poses: Float[np.ndarray, "boxes 3"],
    extents: Float[np.ndarray, "boxes 2"],
) -> Bool[np.ndarray, " boxes"]:
    """Return a mask of the boxes that overlap one box, with a fast radius test for distant ones."""
    hit = np.zeros(len(poses), dtype=bool)
    if len(poses) == 0:
        return hit
    reach = 0.5 * math.hypot(*extent) + 0.5 * (extents[:, 0] + extents[:, 1])
    dx, dy = poses[:, 0] - pose[0], poses[:, 1] - pose[1]
    near = (dx * dx + dy * dy < reach * reach).nonzero()[0]
    if near.size:
        one = np.repeat(np.asarray(pose, dtype=float)[None], near.size, axis=0)
        size = np.repeat(np.asarray(extent, dtype=float)[None], near.size, axis=0)
        hit[near] = overlap(one, size, poses[near].astype(float), extents[near].astype(float))
    return hit
