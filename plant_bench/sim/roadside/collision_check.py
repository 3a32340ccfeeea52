"""Finds pedestrians whose next steps would collide with the ego or a vehicle."""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from plant_bench.geometry.box import overlap_one
from plant_bench.sim.roadside.road_crossing import MovingVehicle
from plant_bench.sim.vehicle_types import WALKER
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EgoState

BODY = (WALKER.length, WALKER.width)
LOOK_AHEAD = (0.2, 0.5, 0.8)  # m ahead that must be free of other boxes
ELBOW_ROOM = 0.2  # m between a walker and a box
NEAR = 2.0  # m around a vehicle's ends within which a walker checks its box


def blocked(
    poses: Float[np.ndarray, "walkers 4"],
    crossing: Int[np.ndarray, " crossing"],
    ego: EgoState,
    others: Sequence[MovingVehicle],
) -> Int[np.ndarray, " blocked"]:
    """Return the rows of walkers that would collide with the ego or, on the road, a vehicle.

    Args:
        poses: Box centres x, y, yaw and z.
        crossing: Rows of walkers on a road.
        ego: The ego.
        others: The vehicles nearby.
    """
    found = []
    away = np.hypot(poses[:, 0] - ego.x, poses[:, 1] - ego.y)
    for row in np.flatnonzero(away < 0.5 * EGO_LENGTH + NEAR).tolist():
        if _will_collide(poses[row], ego.pose, EGO_EXTENT):
            found.append(row)
    for row in crossing.tolist():
        x, y = poses[row, :2].tolist()
        for other in others:
            reach = 0.5 * other.length + NEAR
            if abs(other.x - x) < reach and abs(other.y - y) < reach:
                pose, extent = (other.x, other.y, other.yaw), (other.length, other.width)
                if _will_collide(poses[row], pose, extent):
                    found.append(row)
    return np.array(found, np.intp)


def _will_collide(
    walker: Float[np.ndarray, " 4"], pose: tuple[float, float, float], extent: tuple[float, float]
) -> bool:
    """Tell whether a walker is outside a box now, and would be inside it a little later."""
    x, y, yaw, _ = walker.tolist()
    poses = np.array(
        [(x + by * math.cos(yaw), y + by * math.sin(yaw), yaw) for by in (0.0, *LOOK_AHEAD)]
    )
    size = extent[0] + 2.0 * ELBOW_ROOM, extent[1] + 2.0 * ELBOW_ROOM
    hits = overlap_one(pose, size, poses, np.tile(BODY, (len(poses), 1)))
    return bool(hits[1:].any() and not hits[0])
