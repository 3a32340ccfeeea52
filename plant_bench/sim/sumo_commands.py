"""Commands to single SUMO vehicles: place, drive, brake, release.

Only the modules `sumo*` use libsumo; `Sumo.commands` is the only instance of `Commands`.
"""

import contextlib
import math

from plant_bench.sim.sumo_library import libsumo

MATCH_RADIUS = 8.0  # m around a place in which SUMO looks for its lane; the default costs 4 times
PLACED_MODE = 0  # SUMO's speed mode: no checks
DEFAULT_MODE = 31  # SUMO's speed mode: obeys safe gaps, limits, right of way and lights
DEFAULT_LANE_CHANGES = 1621  # SUMO's lane change mode
CENTRED = 0.02  # m from its lane's centre line within which a driver is not changing lanes
RULE_IGNORING_MODE = 39  # safe gap and limits of acceleration only; ignores foes inside junctions
RULE_IGNORING_FACTOR = 1.5  # times the lane's speed limit, for a driver that ignores rules


def place_vehicle(name: str, length: float, x: float, y: float, yaw: float, speed: float) -> None:
    """Place a vehicle by its box centre; SUMO's own place is that of the front bumper.

    Raises:
        libsumo.TraCIException: SUMO does not know the vehicle.
    """
    front_x, front_y = x + 0.5 * length * math.cos(yaw), y + 0.5 * length * math.sin(yaw)
    angle = 90.0 - math.degrees(yaw)
    libsumo.vehicle.moveToXY(name, "", 0, front_x, front_y, angle, 2, MATCH_RADIUS)
    libsumo.vehicle.setSpeed(name, speed)


class Commands:
    """Commands to vehicles of a running simulation, by actor id; mutable."""

    def __init__(self) -> None:
        self._speed_factors: dict[
            int, float
        ] = {}  # original speed factors of drivers that ignore rules

    def add_scripted(self, vehicle: int, kind: str, edge: str) -> None:
        """Add a vehicle that `place` moves; call `place` before the next step."""
        name = str(vehicle)
        route = f"r{name}"
        libsumo.route.add(route, (edge,))
        libsumo.vehicle.add(name, route, typeID=kind, departSpeed="0")
        libsumo.vehicle.setSpeedMode(name, PLACED_MODE)
        libsumo.vehicle.setLaneChangeMode(name, 0)

    def place(
        self, vehicle: int, length: float, x: float, y: float, yaw: float, speed: float
    ) -> None:
        """Place a scripted vehicle's box centre."""
        place_vehicle(str(vehicle), length, x, y, yaw, speed)

    def keep_lane(self, vehicle: int) -> None:
        """Forbid lane changes of a vehicle; call before it is placed.

        A lane change that SUMO has begun continues while the vehicle is placed, and SUMO crashes
        halfway if there is no lane on that side at the vehicle's position.
        """
        libsumo.vehicle.setLaneChangeMode(str(vehicle), 0)

    def is_centred(self, vehicle: int) -> bool:
        """Tell whether a vehicle is at its lane's centre line, not between two lanes."""
        return abs(libsumo.vehicle.getLateralLanePosition(str(vehicle))) < CENTRED

    def withdraw(self, vehicle: int) -> None:
        """Remove a vehicle that is on the road or about to enter; no error if it has left."""
        with contextlib.suppress(libsumo.TraCIException):
            libsumo.vehicle.remove(str(vehicle))

    def ignore(self, vehicle: int, others: tuple[int, ...]) -> None:
        """Let a driver ignore the given vehicles at junctions; an empty tuple resets this."""
        with contextlib.suppress(libsumo.TraCIException):  # it may have left
            names = " ".join(map(str, others))
            libsumo.vehicle.setParameter(str(vehicle), "junctionModel.ignoreIDs", names)

    def is_out_of_order(self, vehicle: int) -> bool:
        """Tell whether SUMO's order of vehicles on a vehicle's lane contradicts their positions."""
        of, name = libsumo.vehicle, str(vehicle)
        lane = of.getLaneID(name)
        names = libsumo.lane.getLastStepVehicleIDs(lane) if lane else ()
        if len(names) < 2 or name not in names:
            return False
        place = names.index(name)
        around = names[max(place - 1, 0) : place + 2]  # the rear first
        places = [of.getLanePosition(each) for each in around]
        return places != sorted(places)

    def reseat(self, vehicle: int) -> None:
        """Move a placed vehicle to the next lane and back, so that SUMO sorts the lane again.

        Vehicles that SUMO drives are left alone: they would return to their lane's centre.

        SUMO sorts a lane only when a vehicle enters it: a driver that has passed a placed vehicle
        (SUMO does not distinguish beside from through) would still follow it.
        """
        of, name = libsumo.vehicle, str(vehicle)
        lane, at = of.getLaneID(name), of.getLanePosition(name)
        edge, _, index = lane.rpartition("_")
        if libsumo.edge.getLaneNumber(edge) == 1 or of.getSpeedMode(name) != PLACED_MODE:
            return
        with contextlib.suppress(libsumo.TraCIException):  # the edge may not be on its route
            of.moveTo(name, f"{edge}_{1 if index == '0' else int(index) - 1}", at)
            of.moveTo(name, lane, at)

    def drive(self, vehicle: int, speed: float, *, ignores_rules: bool) -> None:
        """Command a vehicle's speed; with `ignores_rules` it only keeps safe gaps."""
        name = str(vehicle)
        libsumo.vehicle.setSpeedMode(name, RULE_IGNORING_MODE if ignores_rules else DEFAULT_MODE)
        if ignores_rules:
            self._speed_factors.setdefault(vehicle, libsumo.vehicle.getSpeedFactor(name))
            libsumo.vehicle.setSpeedFactor(name, RULE_IGNORING_FACTOR)
        libsumo.vehicle.setLaneChangeMode(name, 0)
        libsumo.vehicle.setSpeed(name, speed)

    def brake(self, vehicle: int, deceleration: float) -> None:
        """Brake a vehicle to a stop with a deceleration, m/s2."""
        name = str(vehicle)
        libsumo.vehicle.setDecel(name, deceleration)
        libsumo.vehicle.setSpeed(name, 0.0)

    def release(self, vehicle: int) -> None:
        """Undo all commands to a vehicle, if it is still on the road."""
        name = str(vehicle)
        if name not in libsumo.vehicle.getIDList():
            return
        libsumo.vehicle.setSpeed(name, -1.0)
        libsumo.vehicle.setSpeedMode(name, DEFAULT_MODE)
        kind, *_ = libsumo.vehicle.getTypeID(name).split(
            "@"
        )  # SUMO's name for a changed type is "kind@id"
        libsumo.vehicle.setDecel(name, libsumo.vehicletype.getDecel(kind))
        if vehicle in self._speed_factors:
            libsumo.vehicle.setSpeedFactor(name, self._speed_factors.pop(vehicle))
        libsumo.vehicle.setLaneChangeMode(name, DEFAULT_LANE_CHANGES)
