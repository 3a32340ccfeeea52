"""Resolves gridlock: the ego and SUMO drivers, or drivers alone, that wait for each other.

SUMO's drivers wait for a stationary vehicle on a junction near their path's end, even if they could
drive on and thereby make space. A human would. If the path of such a driver is free, it ignores the
ego, and other stationary vehicles inside the junction, for a few seconds.

Drivers also wait for each other in a circle: a bus that turns left yields to an oncoming car, which
cannot pass the bus; a vehicle in a small ring yields to the queue behind itself. A driver that has
waited for long, not at a red light, ignores those that are stationary too if its path is free.
Drivers that are so close that none can move would stay for ever. They are removed after 90 s, as in
CARLA's traffic (docs/reference/protocol.md); SUMO does so after 300 s (`--time-to-teleport`).

A pedestrian who stops on a crossing because a vehicle is in the way can be what this vehicle waits
for. The driver ignores such a pedestrian, too, if its path is free.

On a lane, a driver may pass an ego that is between two lanes. SUMO still treats the ego as its
leader, so both wait for ever, and drivers behind hit the ego. So the lane's order is corrected.
"""

from collections.abc import Callable, Iterable, Mapping
from collections.abc import Set as AbstractSet
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

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
CLEAR_PATH = 10  # m of a driver's path that must be free
MARGIN = 0.1  # m around vehicles and pedestrians
STOPPED_SPEED = 0.1  # m/s
LOOK_INTERVAL = 20  # ticks between two checks: 1 s
ORDER_INTERVAL = 10  # ticks between two checks of the order on the ego's lane


_Box = tuple[tuple[float, float, float], tuple[float, float]]  # pose, and length and width
_NO_PROXIES: Mapping[int, int] = MappingProxyType({})


class _Driver(NamedTuple):
    """A stationary driver that may wait for others without need.

    Attributes:
        vehicle: Its actor id.
        lane: SUMO's name of its lane.
        path: Its next poses x, y, yaw, one a metre.
        extent: Its length and width, metres.
    """

    vehicle: int
    lane: str
    path: Float[np.ndarray, "poses 3"]
    extent: Float[np.ndarray, " 2"]


class Gridlock:
    """Detects and resolves gridlock; mutable.

    Args:
        commands: Commands to the drivers.
        scripted: The vehicles that hazards command now; they are left alone.
        proxies: The SUMO vehicles that represent pedestrians now, by the pedestrians' ids.
    """

    def __init__(
        self,
        commands: Commands,
        scripted: AbstractSet[int] = frozenset(),
        proxies: Mapping[int, int] = _NO_PROXIES,
    ) -> None:
        self._commands = commands
        self._scripted = scripted
        self._proxies = proxies
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
        """Release or remove the stationary drivers that wait without need."""
        vehicles = actors.only(np.arange(len(states)))
        standing = np.flatnonzero(vehicles.speeds < STOPPED_SPEED)
        ids = vehicles.ids[standing].tolist()
        since = self._waiting_since
        self._waiting_since = {vehicle: since.get(vehicle, tick) for vehicle in ids}
        ego_stands = _lasts(self._standing_since, tick, MIN_STANDSTILL)
        near_ego = _near(vehicles, ego.x, ego.y)
        lanes = [state.lane for state in states.values()]
        rows = [
            row
            for row, vehicle in zip(standing.tolist(), ids, strict=True)
            if vehicle not in self._released
            and vehicle not in self._scripted
            and (
                (ego_stands and near_ego[row] and _is_inside_junction(lanes[row]))
                or self._waits_for_long(tick, vehicle, lanes[row])
            )
        ]
        if not rows:
            return
        paths = facts().paths
        walkers = actors.only(np.isin(actors.ids, list(self._proxies)))
        for row in rows:
            x, y = vehicles.poses[row, :2].tolist()
            others = vehicles.only(standing[standing != row])
            others, beside = (group.only(_near(group, x, y)) for group in (others, walkers))
            driver = _Driver(
                int(vehicles.ids[row]), lanes[row], paths[row], vehicles.extents[row].astype(float)
            )
            if not _is_free(driver, [(ego.pose, EGO_EXTENT)]):
                continue
            if _is_free(driver, _boxes(beside)) and not self._blockers(driver, others):
                self._release(tick, driver, ego_stands=ego_stands, others=others, walkers=beside)
            else:
                self._remove_if_locked(tick, driver)

    def _blockers(self, driver: _Driver, others: Actors) -> list[int]:
        """Return the vehicles on a driver's path; its own followers do not count.

        A lane of an imported map may be folded back, so that a follower's box is ahead.
        """
        boxes = zip(others.ids.tolist(), _boxes(others), strict=True)
        on_path = [vehicle for vehicle, box in boxes if not _is_free(driver, [box])]
        return [vehicle for vehicle in on_path if self._commands.leader(vehicle) != driver.vehicle]

    def _waits_for_long(self, tick: int, vehicle: int, lane: str) -> bool:
        """Tell whether a driver may be one of a circle of drivers that wait for each other."""
        patience = MIN_WAIT_AGAIN if lane in self._circles else MIN_WAIT
        return _lasts(self._waiting_since[vehicle], tick, patience)

    def _release(
        self, tick: int, driver: _Driver, *, ego_stands: bool, others: Actors, walkers: Actors
    ) -> None:
        """Let a driver with a free path ignore whom it may wait for, unless its light is red."""
        if not _is_inside_junction(driver.lane) and self._commands.is_at_red_light(driver.vehicle):
            return
        if _lasts(self._waiting_since[driver.vehicle], tick, MIN_WAIT):
            self._circles.add(driver.lane)
        ignored = [int(EGO_ID)] if ego_stands else []
        ignored += others.ids.tolist()
        ignored += [self._proxies[walker] for walker in walkers.ids.tolist()]
        self._commands.ignore(driver.vehicle, tuple(ignored))
        self._released[driver.vehicle] = tick + round(RELEASE / TICK)

    def _remove_if_locked(self, tick: int, driver: _Driver) -> None:
        """Remove a driver that has been locked by others inside a junction for very long."""
        waiting_since = self._waiting_since[driver.vehicle]
        if _is_inside_junction(driver.lane) and _lasts(waiting_since, tick, MAX_WAIT):
            self._commands.withdraw(driver.vehicle)


def _is_inside_junction(lane: str) -> bool:
    return lane.startswith(":")


def _lasts(since: int | None, tick: int, duration: float) -> bool:
    """Tell whether something that began at a tick has lasted for a duration, s."""
    return since is not None and (tick - since) * TICK >= duration


def _near(actors: Actors, x: float, y: float) -> Bool[np.ndarray, " actors"]:
    """Return a mask of the actors near a place."""
    return np.hypot(*(actors.poses[:, :2] - (x, y)).T) < REACH


def _boxes(actors: Actors) -> list[_Box]:
    """Return pose and size of each actor."""
    rows = zip(actors.poses.astype(float).tolist(), actors.extents.tolist(), strict=True)
    return [((x, y, yaw), (length, width)) for (x, y, yaw), (length, width) in rows]


def _is_free(driver: _Driver, boxes: Iterable[_Box]) -> bool:
    """Tell whether the path right ahead of a driver is free of boxes.

    Boxes that overlap it already do not count: some imported maps have lanes on top of others.
    """
    ahead = driver.path[: CLEAR_PATH + 1]
    extents = np.repeat(driver.extent[None], len(ahead), axis=0)
    for pose, (length, width) in boxes:
        size = length + 2.0 * MARGIN, width + 2.0 * MARGIN
        overlaps = overlap_one(pose, size, ahead, extents)
        if overlaps[1:].any() and not overlaps[0]:
            return False
    return True
