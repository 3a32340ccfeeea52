"""What single vehicles are told: how SUMO is made to place, drive, stop and release one.

Part of the only door to libsumo; `Sumo.commands` is the only instance.
"""

import contextlib
import math

from plant_bench.sim.sumo_library import libsumo

MATCH_RADIUS = 8.0  # m around a place in which SUMO looks for its lane; the default costs 4 times
PLACED_MODE = 0  # SUMO's speed mode: minds nothing
DEFAULT_MODE = 31  # SUMO's speed mode: minds safe gaps, limits, foes and lights
DEFAULT_LANE_CHANGES = 1621  # SUMO's lane change mode
CENTRED = 0.02  # m beside its lane's middle within which a driver is not changing lanes
RULE_IGNORING_MODE = 39  # safe gap and limits of acceleration only; ignores foes inside junctions
RULE_IGNORING_FACTOR = 1.5  # a ignores_rules driver's speed limit, times the lane's


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
    """Commands to single vehicles of a running simulation, by number; mutable."""

    def __init__(self) -> None:
        self._tempers: dict[int, float] = {}  # speed factors of the drivers now ignores_rules

    def add_scripted(self, vehicle: int, kind: str, edge: str) -> None:
        """Add a vehicle that is placed by `place` from now on; do so before the next step."""
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
        """Have a vehicle begin no lane change of its own; needed before it is placed.

        A change that SUMO has begun goes on while the vehicle is placed, and SUMO dies when it is
        half done and there is no further lane on that side of where the vehicle is by then.
        """
        libsumo.vehicle.setLaneChangeMode(str(vehicle), 0)

    def is_centred(self, vehicle: int) -> bool:
        """Tell whether a vehicle on the road is in its lane's middle, not between two lanes."""
        return abs(libsumo.vehicle.getLateralLanePosition(str(vehicle))) < CENTRED

    def withdraw(self, vehicle: int) -> None:
        """Take a vehicle off the road, or keep it from entering; as well if it has left."""
        with contextlib.suppress(libsumo.TraCIException):
            libsumo.vehicle.remove(str(vehicle))

    def ignore(self, vehicle: int, others: tuple[int, ...]) -> None:
        """Have a driver take no notice of some vehicles on junctions; of none, to undo that."""
        with contextlib.suppress(libsumo.TraCIException):  # it may have left
            names = " ".join(map(str, others))
            libsumo.vehicle.setParameter(str(vehicle), "junctionModel.ignoreIDs", names)

    def is_out_of_order(self, vehicle: int) -> bool:
        """Tell whether SUMO's order of those on a vehicle's lane is not that of their places."""
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
        """Move a placed vehicle to the next lane and back, so that SUMO knows who is before it.

        One that SUMO drives is left alone: it would come back to the middle of its lane.

        SUMO keeps the order of those on a lane: one that has driven past a placed vehicle (beside
        it, which SUMO does not tell from through it) still follows it. Only entering sorts.
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
        """Command a vehicle's speed; a ignores_rules one keeps its distance, but no other rule."""
        name = str(vehicle)
        libsumo.vehicle.setSpeedMode(name, RULE_IGNORING_MODE if ignores_rules else DEFAULT_MODE)
        if ignores_rules:
            self._tempers.setdefault(vehicle, libsumo.vehicle.getSpeedFactor(name))
            libsumo.vehicle.setSpeedFactor(name, RULE_IGNORING_FACTOR)
        libsumo.vehicle.setLaneChangeMode(name, 0)
        libsumo.vehicle.setSpeed(name, speed)

    def brake(self, vehicle: int, deceleration: float) -> None:
        """Let a vehicle brake to a stop, m/s2."""
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
        kind, *_ = libsumo.vehicle.getTypeID(name).split("@")  # a changed one's is "kind@id"
        libsumo.vehicle.setDecel(name, libsumo.vehicletype.getDecel(kind))
        if vehicle in self._tempers:
            libsumo.vehicle.setSpeedFactor(name, self._tempers.pop(vehicle))
        libsumo.vehicle.setLaneChangeMode(name, DEFAULT_LANE_CHANGES)
