"""Which actors a careful driver need not forecast, or must not wait for."""

import math

import numpy as np
from jaxtyping import Bool

from plant_bench.agents.corridor import Corridor
from plant_bench.agents.forecast import MARGIN_ALONG, STANDING, Forecast
from plant_bench.geometry.box import overlap_one
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH, Actors, EgoState

HALF = 0.5 * EGO_LENGTH
SAME_WAY = 0.7  # cosine of the angle to the ego from which on somebody drives its way
FOLLOWER_BRAKING = 3.0  # m/s2 that whoever comes from behind is trusted with
FOLLOWER_GAP = 1.0  # m that it keeps


def left_behind(ego: EgoState, actors: Actors) -> Bool[np.ndarray, " actors"]:
    """Tell who stands touching the ego and is not ahead of it: to wait would not undo that."""
    touching = actors.speeds < STANDING
    near = touching.nonzero()[0]
    touching[near] = overlap_one(ego.pose, EGO_EXTENT, actors.poses[near], actors.extents[near])
    if touching.any():
        dx, dy = actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y
        touching &= math.cos(ego.yaw) * dx + math.sin(ego.yaw) * dy < HALF
    return touching


def may_conflict(ego: EgoState, actors: Actors, ahead: Corridor) -> Bool[np.ndarray, " actors"]:
    """Tell which actors a forecast is needed for: not the leader's queue, not who follows."""
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y
    forward, left = cos * dx + sin * dy, cos * dy - sin * dx
    aligned = np.cos(actors.poses[:, 2] - ego.yaw) > 0.8
    follows = (forward < -HALF) & (np.abs(left) < 0.5 * EGO_WIDTH + 0.5) & aligned
    leads = ahead.inside & ~ahead.crossing
    reach = 20.0 + 5.0 * (ego.speed + actors.speeds)
    room = 0.5 * (EGO_LENGTH + EGO_WIDTH + actors.extents.sum(axis=1)) + 2.0 * MARGIN_ALONG
    parked = (actors.speeds < STANDING) & (ahead.aside > room)
    return ~follows & ~leads & ~parked & (dx * dx + dy * dy < reach * reach)


def brake_for_ego(ego: EgoState, actors: Actors, forecast: Forecast) -> Bool[np.ndarray, " actors"]:
    """Tell who comes from behind, whose way the ego is in already, and who can fall in behind it.

    Forecasts do not react to the ego. To brake before such a follower would bring about what they
    warn of.

    Args:
        ego: The ego.
        actors: Those of the forecast, in its order.
        forecast: Where they go.
    """
    cos, sin = np.cos(actors.poses[:, 2]), np.sin(actors.poses[:, 2])
    dx, dy = ego.x - actors.poses[:, 0], ego.y - actors.poses[:, 1]
    turn = cos * math.cos(ego.yaw) + sin * math.sin(ego.yaw)
    # Of the ego's box, what lies behind its centre along the other's heading, at the most.
    reach = HALF * np.abs(turn) + 0.5 * EGO_WIDTH * np.sqrt(np.maximum(1.0 - turn * turn, 0.0))
    gap = cos * dx + sin * dy - reach - 0.5 * actors.extents[:, 0] - FOLLOWER_GAP
    closing = np.maximum(actors.speeds - ego.speed * turn, 0.0)
    able = (gap > 0.0) & (closing**2 < 2.0 * FOLLOWER_BRAKING * gap)
    rows = np.flatnonzero(able)
    if rows.size:
        poses = forecast.poses[rows]
        widths = np.broadcast_to(forecast.widths[rows, None], poses.shape[:2])
        extents = np.stack((forecast.lengths[rows], widths), axis=2)
        meets = overlap_one(ego.pose, EGO_EXTENT, poses.reshape(-1, 3), extents.reshape(-1, 2))
        same_way = np.cos(poses[..., 2] - ego.yaw) > SAME_WAY
        able[rows] = (meets.reshape(same_way.shape) & same_way).any(axis=1)
    return able
