"""Ends stand-offs between the ego and drivers that wait for it.

SUMO's drivers wait for a vehicle that stands on a junction in front of their path's end, even where
they could drive on and thereby make room. A human would. Such a driver is told to take no notice
of the ego, and of those who stand inside the junction as well (behind the ego, often), for a few
seconds, if the road that it would drive is free of them all.

On a lane, a driver may come past an ego that stands between two lanes. SUMO goes on taking the ego
for its leader, and the two wait for ever; who comes from behind minds the driver and hits the ego.
So the ego is put in its place again.
"""

import numpy as np

from plant_bench.agent import Privileged
from plant_bench.geometry.box import overlap_one
from plant_bench.sim.sumo import EGO_ID, VehicleState
from plant_bench.sim.sumo_commands import Commands
from plant_bench.world.scene import EGO_EXTENT, TICK, Actors, EgoState

PATIENCE = 8.0  # s that the ego and the driver have been standing before
RELEASE = 4.0  # s for which the driver takes no notice of the ego
REACH = 40.0  # m from the ego within which drivers are looked at
CLEAR_PATH = 10  # m of a driver's path that must be free of the ego and of who stands
MARGIN = 0.1  # m around those who stand
STANDING = 0.1  # m/s
LOOK_INTERVAL = 20  # ticks between two looks: 1 s
ORDER_INTERVAL = 10  # ticks between two looks at the order on the ego's lane


class Gridlock:
    """Watches over stand-offs; mutable.

    Args:
        commands: To the drivers.
    """

    def __init__(self, commands: Commands) -> None:
        self._commands = commands
        self._standing_since: int | None = None
        self._released: dict[int, int] = {}

    def due(self, tick: int, ego: EgoState) -> bool:
        """Follow the ego, and tell whether it has been standing so long that a look is due.

        Keeps the ego in its place among those on its lane.
        """
        if tick % ORDER_INTERVAL == 0 and self._commands.is_out_of_order(int(EGO_ID)):
            self._commands.reseat(int(EGO_ID))
        if ego.speed > STANDING:
            self._standing_since = None
        elif self._standing_since is None:
            self._standing_since = tick
        for vehicle in [key for key, end in self._released.items() if tick >= end]:
            del self._released[vehicle]
            self._commands.ignore(vehicle, ())
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
        lanes = [state.lane for state in states.values()]
        inside = np.array([lane.startswith(":") for lane in lanes], dtype=bool)
        vehicles = actors.only(np.arange(len(lanes)))
        near = np.hypot(vehicles.poses[:, 0] - ego.x, vehicles.poses[:, 1] - ego.y) < REACH
        stuck = np.flatnonzero(inside & near & (vehicles.speeds < STANDING))
        for row in stuck:
            vehicle = int(vehicles.ids[row])
            others = vehicles.only(stuck[stuck != row])
            if vehicle not in self._released and _is_free(facts, vehicles, int(row), ego, others):
                self._commands.ignore(vehicle, (int(EGO_ID), *others.ids.tolist()))
                self._released[vehicle] = tick + round(RELEASE / TICK)


def _is_free(facts: Privileged, vehicles: Actors, row: int, ego: EgoState, others: Actors) -> bool:
    """Tell whether the road right ahead of a vehicle is free of the ego and of the others."""
    path = facts.paths[row, 1 : CLEAR_PATH + 1]
    extents = np.repeat(vehicles.extents[row][None].astype(float), len(path), axis=0)
    poses = [ego.pose, *map(tuple, others.poses.astype(float).tolist())]
    sizes = np.concatenate((np.array([EGO_EXTENT]), others.extents)) + 2.0 * MARGIN
    return not any(
        overlap_one(pose, (float(size[0]), float(size[1])), path, extents).any()
        for pose, size in zip(poses, sizes, strict=True)
    )
