"""Resolves gridlock between the ego and SUMO drivers that wait for each other.

SUMO's drivers wait for a stationary vehicle on a junction near their path's end, even if they could
drive on and thereby make space. A human would. If the path of such a driver is free, it ignores the
ego, and other stationary vehicles inside the junction, for a few seconds.

On a lane, a driver may pass an ego that is between two lanes. SUMO still treats the ego as its
leader, so both wait for ever, and drivers behind hit the ego. So the lane's order is corrected.
"""

import numpy as np

from plant_bench.agent import Privileged
from plant_bench.geometry.box import overlap_one
from plant_bench.sim.sumo import EGO_ID, VehicleState
from plant_bench.sim.sumo_commands import Commands
from plant_bench.world.scene import EGO_EXTENT, TICK, Actors, EgoState

MIN_STANDSTILL = 8.0  # s that the ego has been stationary
RELEASE = 4.0  # s for which the driver ignores the ego
REACH = 40.0  # m from the ego within which drivers are checked
CLEAR_PATH = 10  # m of a driver's path that must be free of the ego and stationary vehicles
MARGIN = 0.1  # m around stationary vehicles
STOPPED_SPEED = 0.1  # m/s
LOOK_INTERVAL = 20  # ticks between two checks: 1 s
ORDER_INTERVAL = 10  # ticks between two checks of the order on the ego's lane


class Gridlock:
    """Detects and resolves gridlock; mutable.

    Args:
        commands: Commands to the drivers.
    """

    def __init__(self, commands: Commands) -> None:
        self._commands = commands
        self._standing_since: int | None = None
        self._released: dict[int, int] = {}

    def due(self, tick: int, ego: EgoState) -> bool:
        """Update the ego's standstill time, and tell whether a check is due.

        Also keeps the ego in order among the vehicles on its lane.
        """
        if tick % ORDER_INTERVAL == 0 and self._commands.is_out_of_order(int(EGO_ID)):
            self._commands.reseat(int(EGO_ID))
        if ego.speed > STOPPED_SPEED:
            self._standing_since = None
        elif self._standing_since is None:
            self._standing_since = tick
        for vehicle in [key for key, end in self._released.items() if tick >= end]:
            del self._released[vehicle]
            self._commands.ignore(vehicle, ())
        since = self._standing_since
        return (
            since is not None
            and tick % LOOK_INTERVAL == 0
            and (tick - since) * TICK >= MIN_STANDSTILL
        )

    def look(
        self,
        tick: int,
        ego: EgoState,
        actors: Actors,
        facts: Privileged,
        states: dict[int, VehicleState],
    ) -> None:
        """Release stationary drivers inside a junction whose path is free."""
        lanes = [state.lane for state in states.values()]
        inside = np.array([lane.startswith(":") for lane in lanes], dtype=bool)
        vehicles = actors.only(np.arange(len(lanes)))
        near = np.hypot(vehicles.poses[:, 0] - ego.x, vehicles.poses[:, 1] - ego.y) < REACH
        stuck = np.flatnonzero(inside & near & (vehicles.speeds < STOPPED_SPEED))
        for row in stuck:
            vehicle = int(vehicles.ids[row])
            others = vehicles.only(stuck[stuck != row])
            if vehicle not in self._released and _is_free(facts, vehicles, int(row), ego, others):
                self._commands.ignore(vehicle, (int(EGO_ID), *others.ids.tolist()))
                self._released[vehicle] = tick + round(RELEASE / TICK)


def _is_free(facts: Privileged, vehicles: Actors, row: int, ego: EgoState, others: Actors) -> bool:
    """Tell whether the path right ahead of a vehicle is free of the ego and the others."""
    path = facts.paths[row, 1 : CLEAR_PATH + 1]
    extents = np.repeat(vehicles.extents[row][None].astype(float), len(path), axis=0)
    poses = [ego.pose, *map(tuple, others.poses.astype(float).tolist())]
    sizes = np.concatenate((np.array([EGO_EXTENT]), others.extents)) + 2.0 * MARGIN
    return not any(
        overlap_one(pose, (float(size[0]), float(size[1])), path, extents).any()
        for pose, size in zip(poses, sizes, strict=True)
    )
