"""Ends stand-offs inside junctions between the ego and a driver that waits for it.

SUMO's drivers wait for a vehicle that stands on a junction in front of their path's end, even where
they could drive on and thereby make room. A human would. Such a driver is told to take no notice
of the ego for a few seconds, if the road that it would drive is free of the ego.
"""

import numpy as np

from plant_bench.agent import Privileged
from plant_bench.geometry.box import overlap_one
from plant_bench.sim.sumo import Sumo, VehicleState
from plant_bench.world.scene import EGO_EXTENT, TICK, Actors, EgoState

PATIENCE = 8.0  # s that the ego and the driver have been standing before
RELEASE = 4.0  # s for which the driver takes no notice of the ego
REACH = 20.0  # m from the ego within which drivers are looked at
CLEAR_PATH = 10  # m of a driver's path that must be free of the ego
MARGIN = 0.1  # m around the ego
STANDING = 0.1  # m/s
LOOK_INTERVAL = 20  # ticks between two looks: 1 s


class Deadlocks:
    """Watches over stand-offs; mutable.

    Args:
        sumo: The running simulation.
    """

    def __init__(self, sumo: Sumo) -> None:
        self._sumo = sumo
        self._standing_since: int | None = None
        self._released: dict[int, int] = {}

    def due(self, tick: int, ego: EgoState) -> bool:
        """Follow the ego, and tell whether it has been standing so long that a look is due."""
        if ego.speed > STANDING:
            self._standing_since = None
        elif self._standing_since is None:
            self._standing_since = tick
        for vehicle in [key for key, end in self._released.items() if tick >= end]:
            del self._released[vehicle]
            self._sumo.ignore_ego(vehicle, ignore=False)
        since = self._standing_since
        return since is not None and tick % LOOK_INTERVAL == 0 and (tick - since) * TICK >= PATIENCE

    def look(
        self,
        tick: int,
        ego: EgoState,
        actors: Actors,
        facts: Privileged,
        states: dict[int, VehicleState],
    ) -> None:
        """Release drivers that stand inside a junction with a free road before them."""
        size = (EGO_EXTENT[0] + 2 * MARGIN, EGO_EXTENT[1] + 2 * MARGIN)
        for row, (vehicle, state) in enumerate(states.items()):
            inside = state.lane.startswith(":")
            if not inside or state.speed > STANDING or vehicle in self._released:
                continue
            x, y, _ = actors.poses[row].tolist()
            if (x - ego.x) ** 2 + (y - ego.y) ** 2 > REACH**2:
                continue
            path = facts.paths[row, 1 : CLEAR_PATH + 1]
            extents = np.repeat(actors.extents[row][None].astype(float), len(path), axis=0)
            if not overlap_one(ego.pose, size, path, extents).any():
                self._sumo.ignore_ego(vehicle, ignore=True)
                self._released[vehicle] = tick + round(RELEASE / TICK)
