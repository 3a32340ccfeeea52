"""Which actors a careful driver need not forecast, or must not wait for."""

import math

import numpy as np
from jaxtyping import Bool

from plant_bench.agents.corridor import Corridor
from plant_bench.agents.forecast import MARGIN_ALONG, STANDING
from plant_bench.geometry.box import overlap_one
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH, Actors, EgoState

HALF = 0.5 * EGO_LENGTH


def left_behind(ego: EgoState, actors: Actors) -> Bool[np.ndarray, " actors"]:
    """Tell who stands touching the ego and is not ahead of it: to wait would not undo that."""
    touching = actors.speeds < STANDING
    near = np.flatnonzero(touching)
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
