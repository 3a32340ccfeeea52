"""Resolves gridlock: the ego and SUMO drivers, or drivers alone, that wait for each other.

SUMO's drivers wait for a stationary vehicle on a junction near their path's end, even if they could
drive on and thereby make space. A human would. If the path of such a driver is free, it ignores the
ego, and other stationary vehicles inside the junction, for a few seconds.

Drivers also wait for each other in a circle: a bus that turns left yields to an oncoming car, which
cannot pass the bus; a vehicle in a small ring yields to the queue behind itself. A driver that has
waited for long, not at a red light, ignores those that are stationary too if its path is free.
Drivers that are so close that none can move would stay for ever. They are removed after 90 s, as in
CARLA's traffic (docs/reference/protocol.md); SUMO does so after 300 s (`--time-to-teleport`).

On a lane, a driver may pass an ego that is between two lanes. SUMO still treats the ego as its
leader, so both wait for ever, and drivers behind hit the ego. So the lane's order is corrected.
"""

from collections.abc import Callable
from collections.abc import Set as AbstractSet

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Privileged
from plant_bench.geometry.box import overlap_one
from plant_bench.sim.sumo import EGO_ID, VehicleState
from plant_bench.sim.sumo_commands import Commands
from plant_bench.world.scene import EGO_EXTENT, TICK, Actors, EgoState

MIN_STANDSTILL = 8.0  # s that the ego has been stationary
MIN_WAIT = 15.0  # s that a driver has been stationary before it is checked for a circle of drivers
MIN_WAIT_AGAIN = 2.0  # s, on a lane where a driver had to be released before
MAX_WAIT = 90.0  # s: after it a driver inside a junction is removed, unless the ego blocks it
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
        scripted: The vehicles that hazards command now; they are left alone.
    """

    def __init__(self, commands: Commands, scripted: AbstractSet[int] = frozenset()) -> None:
        self._commands = commands
        self._scripted = scripted
        self._standing_since: int | None = None
        self._waiting_since: dict[int, int] = {}
        self._released: dict[int, int] = {}
        self._circles: set[str] = set()  # lanes on which drivers had to be released

    def step(
        self,
        tick: int,
        ego: EgoState,
        actors: Actors,
        states: dict[int, VehicleState],
        facts: Callable[[], Privileged],
    ) -> None:
        """Observe who is stationary, release drivers that wait in a circle, end old releases.

        Also keeps the ego in order among the vehicles on its lane.

        Args:
            tick: Current tick.
            ego: The ego.
            actors: All actors in sight; the vehicles come first, in the order of `states`.
            states: SUMO's states of the vehicles, by their ids.
            facts: Returns the privileged facts of `actors`; called only if they are needed.
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
        if tick % LOOK_INTERVAL == 0:
            self._look(tick, ego, actors, states, facts)

    def _look(
        self,
        tick: int,
        ego: EgoState,
        actors: Actors,
        states: dict[int, VehicleState],
        facts: Callable[[], Privileged],
    ) -> None:
        """Release the stationary drivers whose path is free."""
        vehicles = actors.only(np.arange(len(states)))
        standing = np.flatnonzero(vehicles.speeds < STOPPED_SPEED)
        ids = vehicles.ids[standing].tolist()
        since = self._waiting_since
        self._waiting_since = {vehicle: since.get(vehicle, tick) for vehicle in ids}
        ego_stands = _lasts(self._standing_since, tick, MIN_STANDSTILL)
        near = np.hypot(vehicles.poses[:, 0] - ego.x, vehicles.poses[:, 1] - ego.y) < REACH
        lanes = [state.lane for state in states.values()]
        candidates = [
            (int(row), vehicle)
            for row, vehicle in zip(standing, ids, strict=True)
            if vehicle not in self._released
            and vehicle not in self._scripted
            and (
                (ego_stands and near[row] and lanes[row].startswith(":"))
                or _lasts(self._waiting_since[vehicle], tick, self._patience(lanes[row]))
            )
        ]
        if not candidates:
            return
        paths = facts().paths
        for row, vehicle in candidates:
            x, y = vehicles.poses[row, :2]
            around = np.hypot(*(vehicles.poses[standing, :2] - (x, y)).T) < REACH
            others = vehicles.only(standing[around & (standing != row)])
            if not _is_free(paths[row], vehicles, row, ego, others):
                if (
                    lanes[row].startswith(":")
                    and _lasts(self._waiting_since[vehicle], tick, MAX_WAIT)
                    and _is_free(paths[row], vehicles, row, ego, others.only(np.arange(0)))
                ):
                    self._commands.withdraw(vehicle)
                continue
            if not lanes[row].startswith(":") and self._commands.is_at_red_light(vehicle):
                continue
            if _lasts(self._waiting_since[vehicle], tick, MIN_WAIT):
                self._circles.add(lanes[row])
            ignored = (int(EGO_ID),) if ego_stands else ()
            self._commands.ignore(vehicle, (*ignored, *others.ids.tolist()))
            self._released[vehicle] = tick + round(RELEASE / TICK)

    def _patience(self, lane: str) -> float:
        """Return how long a driver on a lane waits before it is checked, s."""
        return MIN_WAIT_AGAIN if lane in self._circles else MIN_WAIT


def _lasts(since: int | None, tick: int, duration: float) -> bool:
    """Tell whether something that began at a tick has lasted for a duration, s."""
    return since is not None and (tick - since) * TICK >= duration


def _is_free(
    path: Float[np.ndarray, "poses 3"], vehicles: Actors, row: int, ego: EgoState, others: Actors
) -> bool:
    """Tell whether the path right ahead of a vehicle is free of the ego and the others.

    Vehicles that overlap it already do not count: some imported maps have lanes on top of others.
    """
    ahead = path[: CLEAR_PATH + 1]
    extents = np.repeat(vehicles.extents[row][None].astype(float), len(ahead), axis=0)
    poses = [ego.pose, *map(tuple, others.poses.astype(float).tolist())]
    sizes = np.concatenate((np.array([EGO_EXTENT]), others.extents)) + 2.0 * MARGIN
    for pose, size in zip(poses, sizes, strict=True):
        overlaps = overlap_one(pose, (float(size[0]), float(size[1])), ahead, extents)
        if overlaps[1:].any() and not overlaps[0]:
            return False
    return True
