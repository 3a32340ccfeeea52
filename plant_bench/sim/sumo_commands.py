"""Commands to single SUMO vehicles: place, drive, brake, release.

Only the modules `sumo*` use libsumo; `Sumo.commands` is the only instance of `Commands`.
"""

import contextlib

from plant_bench.sim.sumo_library import libsumo
from plant_bench.sim.sumo_placement import PLACED_MODE, Placements

DEFAULT_MODE = 31  # SUMO's speed mode: obeys safe gaps, limits, right of way and lights
DEFAULT_LANE_CHANGES = 1621  # SUMO's lane change mode
CENTRED = 0.02  # m from its lane's centre line within which a driver is not changing lanes
AT_LIGHT = 10.0  # m before its stop line within which a vehicle waits for a signal
LEADER_RANGE = 20.0  # m ahead in which a driver's leader is looked up
GREEN = "GgOo"  # SUMO's states of a signal at which a driver may go; "o" and "O" are off
RULE_IGNORING_MODE = 39  # safe gap and limits of acceleration only; ignores foes inside junctions
RULE_IGNORING_FACTOR = 1.5  # times the lane's speed limit, for a driver that ignores rules


class Commands:
    """Commands to vehicles of a running simulation, by actor id; mutable.

    A command to a vehicle that has left the simulation has no effect.

    Args:
        placements: The vehicles that are placed.
    """

    def __init__(self, placements: Placements) -> None:
        self._placements = placements
        self._speed_factors: dict[int, float] = {}  # original ones of drivers that ignore rules

    def add_scripted(self, vehicle: int, kind: str, edge: str) -> None:
        """Add a vehicle that `place` moves; call `place` before the next step."""
        self._placements.insert(str(vehicle), kind, (edge,))

    def place(
        self, vehicle: int, length: float, x: float, y: float, yaw: float, speed: float
    ) -> None:
        """Place a scripted vehicle's box centre."""
        with contextlib.suppress(libsumo.TraCIException):
            self._placements.place(str(vehicle), length, x, y, yaw, speed)

    def keep_lane(self, vehicle: int) -> None:
        """Forbid lane changes of a vehicle; call before it is placed.

        A lane change that SUMO has begun continues while the vehicle is placed, and SUMO crashes
        halfway if there is no lane on that side at the vehicle's position.
        """
        with contextlib.suppress(libsumo.TraCIException):
            libsumo.vehicle.setLaneChangeMode(str(vehicle), 0)

    def is_centred(self, vehicle: int) -> bool:
        """Tell whether a vehicle is at its lane's centre line, not between two lanes."""
        try:
            return abs(libsumo.vehicle.getLateralLanePosition(str(vehicle))) < CENTRED
        except libsumo.TraCIException:
            return False

    def withdraw(self, vehicle: int) -> None:
        """Remove a vehicle that is on the road or about to enter; no error if it has left."""
        self._placements.forget(str(vehicle))
        with contextlib.suppress(libsumo.TraCIException):
            libsumo.vehicle.remove(str(vehicle))

    def ignore(self, vehicle: int, others: tuple[int, ...]) -> None:
        """Let a driver ignore the given vehicles at junctions; an empty tuple resets this."""
        with contextlib.suppress(libsumo.TraCIException):  # it may have left
            names = " ".join(map(str, others))
            libsumo.vehicle.setParameter(str(vehicle), "junctionModel.ignoreIDs", names)

    def leader(self, vehicle: int) -> int | None:
        """Return the vehicle that a driver follows now; None if it follows none nearby."""
        try:
            found = libsumo.vehicle.getLeader(str(vehicle), LEADER_RANGE)
        except libsumo.TraCIException:
            return None
        return int(found[0]) if found is not None and found[0] else None

    def is_at_red_light(self, vehicle: int) -> bool:
        """Tell whether a vehicle is right before a signal that is red or yellow for it."""
        try:
            ahead = libsumo.vehicle.getNextTLS(str(vehicle))
        except libsumo.TraCIException:
            return False
        return bool(ahead) and ahead[0][2] < AT_LIGHT and ahead[0][3] not in GREEN

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
        if name not in libsumo.vehicle.getIDList():
            return
        libsumo.vehicle.setSpeedMode(name, RULE_IGNORING_MODE if ignores_rules else DEFAULT_MODE)
        if ignores_rules:
            self._speed_factors.setdefault(vehicle, libsumo.vehicle.getSpeedFactor(name))
            libsumo.vehicle.setSpeedFactor(name, RULE_IGNORING_FACTOR)
        libsumo.vehicle.setLaneChangeMode(name, 0)
        libsumo.vehicle.setSpeed(name, speed)

    def brake(self, vehicle: int, deceleration: float) -> None:
        """Brake a vehicle to a stop with a deceleration, m/s2."""
        name = str(vehicle)
        with contextlib.suppress(libsumo.TraCIException):
            libsumo.vehicle.setDecel(name, deceleration)
            libsumo.vehicle.setSpeed(name, 0.0)

    def release(self, vehicle: int) -> None:
        """Undo all commands to a vehicle, if it is still on the road."""
        name = str(vehicle)
        self._placements.forget(name)
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
