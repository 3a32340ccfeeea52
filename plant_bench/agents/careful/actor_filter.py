"""Selects the actors that the careful driver forecasts, and those that it need not wait for."""

import math

import numpy as np
from jaxtyping import Bool

from plant_bench.agents.careful.box_overlaps import same_direction_overlaps, stationary_overlaps
from plant_bench.agents.careful.forecast import MARGIN_ALONG, STANDING, Forecast
from plant_bench.agents.careful.leader import Corridor
from plant_bench.jit import BOOL_1D, F32_1D, F32_2D, F64_1D, compiled
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH, Actors, EgoState

HALF = 0.5 * EGO_LENGTH
SAME_DIRECTION = 0.7  # cosine of the relative heading above which an actor drives the ego's way
FOLLOWER_BRAKING = 3.0  # m/s2 that a follower is assumed to brake with
FOLLOWER_GAP = 1.0  # m that a follower keeps
_EXTENT = np.array(EGO_EXTENT)


def stationary_contacts(ego: EgoState, actors: Actors) -> Bool[np.ndarray, " actors"]:
    """Return a mask of stationary actors that touch the ego from beside or behind.

    Waiting would not resolve such a contact.
    """
    return stationary_overlaps(
        np.array(ego.pose), _EXTENT, actors.poses, actors.extents, actors.speeds, STANDING
    )


def may_conflict(ego: EgoState, actors: Actors, ahead: Corridor) -> Bool[np.ndarray, " actors"]:
    """Return a mask of the actors that need a forecast: not the queue ahead, nor followers."""
    return _may_conflict(
        np.array((ego.x, ego.y, ego.yaw, ego.speed)),
        _EXTENT,
        actors.poses,
        np.cos(actors.poses[:, 2] - ego.yaw),
        actors.extents,
        actors.speeds,
        ahead.inside,
        ahead.crossing,
        ahead.aside,
        np.array((STANDING, MARGIN_ALONG)),
    )


@compiled(
    F64_1D,
    F64_1D,
    F32_2D,
    F32_1D,
    F32_2D,
    F32_1D,
    BOOL_1D,
    BOOL_1D,
    F64_1D,
    F64_1D,
)
def _may_conflict(
    ego, extent, poses, alignments, extents, speeds, inside, crossing, asides, numbers
):
    found = np.zeros(len(poses), np.bool_)
    single = np.float32
    cos, sin = single(math.cos(ego[2])), single(math.sin(ego[2]))
    x, y, speed = single(ego[0]), single(ego[1]), single(ego[3])
    behind, beside = single(-0.5 * extent[0]), single(0.5 * extent[1] + 0.5)
    standing, margins = single(numbers[0]), single(2.0 * numbers[1])
    for row in range(len(poses)):
        if inside[row] and not crossing[row]:
            continue
        dx, dy = poses[row, 0] - x, poses[row, 1] - y
        reach = single(20.0) + single(5.0) * (speed + speeds[row])
        if not dx * dx + dy * dy < reach * reach:
            continue
        size = single(extent[0] + extent[1]) + (extents[row, 0] + extents[row, 1])
        if speeds[row] < standing and asides[row] > single(0.5) * size + margins:
            continue
        forward, left = cos * dx + sin * dy, cos * dy - sin * dx
        aligned = alignments[row] > single(0.8)
        found[row] = not (forward < behind and abs(left) < beside and aligned)
    return found


def yielding_followers(
    ego: EgoState, actors: Actors, forecast: Forecast
) -> Bool[np.ndarray, " actors"]:
    """Return a mask of followers that will have to brake for the ego, and can.

    Forecasts do not react to the ego. Braking in front of such a follower would cause the very
    collision that they predict.

    Args:
        ego: The ego.
        actors: The actors of the forecast, in its order.
        forecast: Their predicted motion.
    """
    cos, sin = np.cos(actors.poses[:, 2]), np.sin(actors.poses[:, 2])
    dx, dy = ego.x - actors.poses[:, 0], ego.y - actors.poses[:, 1]
    turn = cos * math.cos(ego.yaw) + sin * math.sin(ego.yaw)
    # How far the ego's box reaches behind its centre along the other's heading.
    reach = HALF * np.abs(turn) + 0.5 * EGO_WIDTH * np.sqrt(np.maximum(1.0 - turn * turn, 0.0))
    gap = cos * dx + sin * dy - reach - 0.5 * actors.extents[:, 0] - FOLLOWER_GAP
    closing = np.maximum(actors.speeds - ego.speed * turn, 0.0)
    able = (gap > 0.0) & (closing**2 < 2.0 * FOLLOWER_BRAKING * gap)
    if not able.any():
        return able
    return same_direction_overlaps(
        np.array(ego.pose),
        _EXTENT,
        forecast.poses,
        forecast.lengths,
        forecast.widths,
        able,
        SAME_DIRECTION,
    )
