"""Interface to libsumo, with `sumo_*` its only users; converts units and reference points.

SUMO measures angles in degrees clockwise from north and places vehicles by the centre of their
front bumper; all other modules use radians counter-clockwise from +x and box centres.
libsumo has one simulation per process.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from plant_bench.errors import SimulationError
from plant_bench.sim.sumo_commands import Commands
from plant_bench.sim.sumo_library import GUI_DELAY, PROGRAM, libsumo
from plant_bench.sim.sumo_placement import Placements
from plant_bench.sim.sumo_signals import Signals
from plant_bench.sim.sumo_window import follow, mark_route
from plant_bench.sim.vehicle_types import TYPES_FILE
from plant_bench.world.actor_ids import EGO
from plant_bench.world.scene import EGO_LENGTH, TICK

EGO_ID = str(EGO)
ACTION_STEP = 0.2  # s between a background driver's decisions: halves the cost of a step
LANE_CHANGE_DURATION = 3.0  # s: without it a lane change is a jump sideways

_POSITION, _ANGLE, _SPEED = 0x39, 0x43, 0x40  # TraCI variables: 3D position, angle, speed
_ACCELERATION, _LANE, _LANE_POSITION, _LATERAL = 0x72, 0x51, 0x56, 0xB8
_VEHICLES = 0xA4  # TraCI command: vehicle variables


class VehicleState(NamedTuple):
    """A vehicle as SUMO reports it; x, y, z of the front bumper; yaw counter-clockwise from +x."""

    x: float
    y: float
    z: float
    yaw: float
    speed: float
    acceleration: float
    lane: str
    lane_position: float
    lateral: float


class NextLink(NamedTuple):
    """One junction ahead on a vehicle's path.

    Attributes:
        target: The lane behind the junction.
        via: The first lane inside.
        open: Whether the junction may be entered now.
    """

    target: str
    via: str
    open: bool


class Sumo:
    """A running SUMO simulation; a context manager, mutable, one per process.

    Args:
        network: The `.net.xml` file.
        seed: SUMO's own random seed.

    Attributes:
        commands: Commands to single vehicles.
        signals: The traffic lights.

    Raises:
        SimulationError: SUMO cannot start.
    """

    def __init__(self, network: Path, seed: int) -> None:
        command = [
            PROGRAM, "-n", str(network), "-a", str(TYPES_FILE), "--seed", str(seed % 2**31),
            "--step-length", str(TICK), "--default.action-step-length", str(ACTION_STEP),
            "--lanechange.duration", str(LANE_CHANGE_DURATION), "--collision.action", "none",
            "--time-to-teleport", "-1", "--time-to-impatience", "60", "--max-depart-delay", "0",
            "--no-step-log", "--no-warnings", "--duration-log.disable",
        ]  # fmt: skip
        if GUI_DELAY:
            command += ["--start", "--quit-on-end", "--delay", GUI_DELAY]
        try:
            libsumo.start(command)
        except libsumo.TraCIException as error:
            message = f"SUMO cannot start on {network}: {error}"
            raise SimulationError(message) from error
        self._placements = Placements()
        self.commands = Commands(self._placements)
        self.signals = Signals()
        self._radius = 0.0  # m, of `watch`
        self._lane_lengths: dict[str, float] = {}
        self._watched: dict[int, VehicleState] = {}  # of this tick, once queried

    def __enter__(self) -> "Sumo":  # noqa: PYI034 - the run-time type check knows no Self
        return self

    def __exit__(self, *_: object) -> None:
        libsumo.close()

    def step(self) -> None:
        """Advance the simulation by one tick."""
        self._watched = {}
        libsumo.simulationStep()
        if EGO_ID in self._placements.restore_arrived():
            self._subscribe()

    def lane_length(self, lane: str) -> float:
        """Return SUMO's length of a lane; its shape may differ by some percent."""
        length = self._lane_lengths.get(lane)
        if length is None:
            length = self._lane_lengths[lane] = libsumo.lane.getLength(lane)
        return length

    def add_ego(self, edges: tuple[str, ...], x: float, y: float, yaw: float) -> None:
        """Insert the ego with its whole route, so that others yield to it on junctions.

        Raises:
            SimulationError: SUMO does not insert it.
        """
        try:
            self._placements.insert(EGO_ID, "ego", edges)
            self.move_ego(x, y, yaw, 0.0)
            libsumo.simulationStep()
            self.move_ego(x, y, yaw, 0.0)
        except libsumo.TraCIException as error:
            message = f"SUMO cannot insert the ego: {error}"
            raise SimulationError(message) from error

    def add_self_driving_ego(self, edges: tuple[str, ...], lane: int, at: float) -> None:
        """Insert an ego that SUMO drives, stationary until `let_ego_go`.

        Raises:
            SimulationError: SUMO does not insert it.
        """
        try:
            libsumo.route.add("ego", edges)
            libsumo.vehicle.add(
                EGO_ID, "ego", typeID="ego",
                departLane=str(lane), departPos=f"{at:.2f}", departSpeed="0",
            )  # fmt: skip
            libsumo.simulationStep()
            libsumo.vehicle.setSpeed(EGO_ID, 0.0)
        except libsumo.TraCIException as error:
            message = f"SUMO cannot insert the ego: {error}"
            raise SimulationError(message) from error

    def show(
        self, route: Float[np.ndarray, "points 2"], hazards: Sequence[tuple[str, float, float]]
    ) -> None:
        """Mark the ego, its route and its hazards (name, x, y) in sumo-gui, if it is used."""
        if GUI_DELAY:
            mark_route(route, hazards)
            follow(EGO_ID)

    def let_ego_go(self) -> None:
        """Let SUMO's driver drive a self-driving ego."""
        libsumo.vehicle.setSpeed(EGO_ID, -1.0)

    def ego(self) -> VehicleState:
        """Return the state of a self-driving ego.

        Raises:
            SimulationError: SUMO has lost it.
        """
        state = self.state_of(int(EGO_ID))
        if state is None:
            message = "SUMO has lost the ego that it drives."
            raise SimulationError(message)
        return state

    def move_ego(self, x: float, y: float, yaw: float, speed: float) -> None:
        """Place the ego's box centre; SUMO only shows it to other drivers.

        Raises:
            SimulationError: SUMO has lost the ego.
        """
        try:
            self._placements.place(EGO_ID, EGO_LENGTH, x, y, yaw, speed)
        except libsumo.TraCIException as error:
            message = f"SUMO has lost the ego: {error}"
            raise SimulationError(message) from error

    def watch(self, radius: float) -> None:
        """Subscribe to all vehicles within `radius` metres of the ego."""
        self._radius = radius
        self._subscribe()

    def _subscribe(self) -> None:
        variables = [
            _POSITION, _ANGLE, _SPEED, _ACCELERATION, _LANE, _LANE_POSITION, _LATERAL
        ]  # fmt: skip
        libsumo.vehicle.subscribeContext(EGO_ID, _VEHICLES, self._radius, variables)

    def watched(self) -> dict[int, VehicleState]:
        """Return the vehicles within the watched radius by id, without the ego."""
        states: dict[int, VehicleState] = {}
        lanes: dict[str, tuple[str, float, float]] = {}
        make, new, radians = (
            VehicleState,
            tuple.__new__,
            math.radians,
        )  # twice as fast as VehicleState(...)
        for name, values in libsumo.vehicle.getContextSubscriptionResults(EGO_ID).items():
            lanes[name] = values[_LANE], values[_LANE_POSITION], values[_LATERAL]
            if name == EGO_ID:
                continue
            states[int(name)] = new(make, (
                *values[_POSITION], radians(90.0 - values[_ANGLE]), values[_SPEED],
                values[_ACCELERATION], values[_LANE], values[_LANE_POSITION], values[_LATERAL],
            ))  # fmt: skip
        self._placements.refresh(lanes)
        self._watched = states
        return states

    def closed_link(self, vehicle: int) -> int:
        """Return the index of the first junction ahead that must not be entered, or -1."""
        for place, link in enumerate(libsumo.vehicle.getNextLinks(str(vehicle))):
            if not link[2]:
                return place
        return -1

    def next_links(self, vehicle: int) -> list[NextLink]:
        """Return the junctions ahead on a vehicle's path."""
        links = libsumo.vehicle.getNextLinks(str(vehicle))
        return [NextLink(link[0], link[4], link[2]) for link in links]

    def vehicles(self) -> list[int]:
        """Return the ids of all vehicles on the road, without the ego."""
        return [int(name) for name in libsumo.vehicle.getIDList() if name != EGO_ID]

    def position(self, vehicle: int) -> tuple[float, float]:
        """Return where a vehicle's front bumper is."""
        state = self._watched.get(vehicle)
        return libsumo.vehicle.getPosition(str(vehicle)) if state is None else (state.x, state.y)

    def waiting_time(self, vehicle: int) -> float:
        """Return how long a vehicle has been stationary, seconds."""
        return libsumo.vehicle.getWaitingTime(str(vehicle))

    def desired_speed_factor(self, vehicle: int) -> float:
        """Return the ratio of a driver's desired speed to the speed limit."""
        return libsumo.vehicle.getSpeedFactor(str(vehicle))

    def remaining_route(self, vehicle: int) -> tuple[str, ...]:
        """Return the edges still to drive, current one first."""
        name = str(vehicle)
        return libsumo.vehicle.getRoute(name)[max(libsumo.vehicle.getRouteIndex(name), 0) :]

    def set_route(self, vehicle: int, edges: tuple[str, ...]) -> bool:
        """Replace a vehicle's route, current edge first; False if SUMO refuses it now."""
        try:
            libsumo.vehicle.setRoute(str(vehicle), edges)
        except libsumo.TraCIException:
            return False
        return True

    def add_vehicle(
        self, vehicle: int, kind: str, edges: tuple[str, ...], lane: int, at: float, speed: float
    ) -> None:
        """Request a vehicle at the next step; SUMO does not insert it if that would be unsafe."""
        route = f"r{vehicle}"
        libsumo.route.add(route, edges)
        libsumo.vehicle.add(
            str(vehicle), route, typeID=kind,
            departLane=str(lane), departPos=f"{at:.2f}", departSpeed=f"{speed:.2f}",
        )  # fmt: skip

    def vehicles_on(self, lane: str) -> list[tuple[int, float, float]]:
        """Return id, lane position and speed of a lane's vehicles, without the ego, rear first."""
        vehicle = libsumo.vehicle
        names = [name for name in libsumo.lane.getLastStepVehicleIDs(lane) if name != EGO_ID]
        return [(int(n), vehicle.getLanePosition(n), vehicle.getSpeed(n)) for n in names]

    def exists(self, vehicle: int) -> bool:
        """Tell whether a vehicle is on the road or about to enter."""
        return vehicle in self._watched or str(vehicle) in libsumo.vehicle.getIDList()

    def state_of(self, vehicle: int) -> VehicleState | None:
        """Return a vehicle's state, None if it is not on the road."""
        if vehicle in self._watched:
            return self._watched[vehicle]
        name = str(vehicle)
        if not self.exists(vehicle):
            return None
        of = libsumo.vehicle
        x, y, z = of.getPosition3D(name)
        return VehicleState(
            x, y, z, math.radians(90.0 - of.getAngle(name)), of.getSpeed(name),
            of.getAcceleration(name), of.getLaneID(name), of.getLanePosition(name),
            of.getLateralSpeed(name),
        )  # fmt: skip

    def remove(self, vehicle: int) -> None:
        """Remove a vehicle."""
        self._watched.pop(vehicle, None)
        self._placements.forget(str(vehicle))
        libsumo.vehicle.remove(str(vehicle))
