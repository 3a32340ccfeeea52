"""Poses and coordinate frames: (x, y, yaw) in metres and radians, counter-clockwise from +x."""

import math

import numpy as np
from jaxtyping import Float


def wrap_angle(angle: float) -> float:
    """Return the angle in [-pi, pi).

    >>> round(wrap_angle(3.5 * math.pi), 6) == round(-0.5 * math.pi, 6)
    True
    """
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def wrap_angles(angles: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """Return the angles in [-pi, pi)."""
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def to_frame(
    points: Float[np.ndarray, "points 2"], x: float, y: float, yaw: float
) -> Float[np.ndarray, "points 2"]:
    """Express world points in the frame of a pose (x forward, y left).

    >>> to_frame(np.array([[1.0, 3.0]]), 1.0, 2.0, math.pi / 2).round(6).tolist()
    [[1.0, 0.0]]
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    dx, dy = points[:, 0] - x, points[:, 1] - y
    return np.stack((cos * dx + sin * dy, cos * dy - sin * dx), axis=1)


def from_frame(
    points: Float[np.ndarray, "points 2"], x: float, y: float, yaw: float
) -> Float[np.ndarray, "points 2"]:
    """Express points in the frame of a pose in the world frame; the inverse of `to_frame`."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    px, py = points[:, 0], points[:, 1]
    return np.stack((x + cos * px - sin * py, y + sin * px + cos * py), axis=1)
