"""Builds a scene's actors and privileged facts from blocks ordered by actor id."""

import math
from collections.abc import Mapping

import numpy as np

from plant_bench.agent import Privileged
from plant_bench.geometry.pose import wrap_angle
from plant_bench.sim.sumo import VehicleState
from plant_bench.sim.traffic import VehicleType
from plant_bench.world.scene import Actors


def vehicle_actors(states: Mapping[int, VehicleState], kinds: Mapping[int, VehicleType]) -> Actors:
    """Return the vehicles that SUMO reports, as actors in the order of `states`.

    Args:
        states: Vehicle states by actor id.
        kinds: Vehicle types by actor id.
    """
    if not states:
        return Actors.none()
    types = [kinds[key] for key in states]
    numbers: list[float] = []  # flat: numpy takes twice as long to read a list of tuples
    for (x, y, _, yaw, speed, *_), kind in zip(states.values(), types, strict=True):
        length, half = kind.length, 0.5 * kind.length
        front_x, front_y = half * math.cos(yaw), half * math.sin(yaw)
        numbers += (x - front_x, y - front_y, wrap_angle(yaw), speed, length, kind.width)
    table = np.array(numbers, np.float32).reshape(-1, 6)
    return Actors(
        ids=np.fromiter(states, np.int64, len(states)),
        poses=table[:, :3],
        speeds=table[:, 3],
        extents=table[:, 4:],
        kinds=np.frombuffer(bytes(kind.kind for kind in types), np.uint8),
    )


def join(*blocks: Actors) -> Actors:
    """Return the actors of all blocks as read-only arrays, shared by the referee and planners.

    The blocks must be ordered by actor id.
    """
    kept = [block for block in blocks if len(block)]
    whole = kept[0] if len(kept) == 1 else _joined(kept)
    for values in (whole.ids, whole.poses, whole.speeds, whole.extents, whole.kinds):
        values.flags.writeable = False
    return whole


def _joined(blocks: list[Actors]) -> Actors:
    if not blocks:
        return Actors.none()
    return Actors(
        np.concatenate([block.ids for block in blocks]),
        np.concatenate([block.poses for block in blocks]),
        np.concatenate([block.speeds for block in blocks]),
        np.concatenate([block.extents for block in blocks]),
        np.concatenate([block.kinds for block in blocks]),
    )


def join_facts(*blocks: Privileged) -> Privileged:
    """Return the facts of all blocks, in the order of `join`."""
    kept = [block for block in blocks if len(block.paths)] or [blocks[0]]
    if len(kept) == 1:
        return kept[0]
    return Privileged(
        np.concatenate([block.paths for block in kept]),
        np.concatenate([block.accelerations for block in kept]),
        np.concatenate([block.desired_speeds for block in kept]),
        np.concatenate([block.stop_distances for block in kept]),
        np.concatenate([block.stopped_for for block in kept]),
    )
