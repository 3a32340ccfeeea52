"""Vehicles that are placed with moveToXY: the ego, hazards' actors and proxies of pedestrians.

SUMO goes on driving a placed vehicle between two placements, and has two faults that end a
simulation:

- A vehicle that reaches the end of its route arrives and is removed; the next placement fails
  (eclipse-sumo/sumo issues 3993 and 4250). Such a vehicle is inserted again at once.
- A vehicle that is placed off all lanes stays registered on a lane beside its last ones, if it
  overlapped that lane when SUMO put it on its last lane. Sorting that lane's vehicles then reads an
  empty vector, and the process dies. Moving the vehicle to another lane and back removes the
  registration.
"""

import contextlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from plant_bench.sim.sumo_library import libsumo

MATCH_RADIUS = (
    8.0  # m around a position in which SUMO looks for its lane; the default costs 4 times
)
PLACED_MODE = 0  # SUMO's speed mode: no checks


@dataclass
class _Placed:
    """A placed vehicle.

    Attributes:
        kind: Its SUMO vehicle type; "" for a vehicle of the traffic, which is not inserted again.
        edges: The route with which it was inserted.
        pose: The last pose of its front (x, y, yaw).
        speed: Its last speed, m/s.
        lane: The last lane on which SUMO had it; "" if none, or if it has left that lane.
        lane_position: SUMO's position on that lane, metres.
    """

    kind: str = ""
    edges: tuple[str, ...] = ()
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: float = 0.0
    lane: str = ""
    lane_position: float = 0.0


class Placements:
    """The placed vehicles of a running simulation, by SUMO's names; mutable."""

    def __init__(self) -> None:
        self._vehicles: dict[str, _Placed] = {}
        self._inserted = 0

    def insert(self, name: str, kind: str, edges: tuple[str, ...]) -> None:
        """Insert a vehicle; call `place` before the next step.

        Raises:
            libsumo.TraCIException: SUMO refuses it.
        """
        self._inserted += 1
        route = f"{name}_{self._inserted}"
        libsumo.route.add(route, edges)
        libsumo.vehicle.add(name, route, typeID=kind, departSpeed="0")
        libsumo.vehicle.setSpeedMode(name, PLACED_MODE)
        libsumo.vehicle.setLaneChangeMode(name, 0)
        self._vehicles[name] = _Placed(kind, edges)

    def place(self, name: str, length: float, x: float, y: float, yaw: float, speed: float) -> None:
        """Place a vehicle by its box centre; SUMO's own position is that of the front bumper.

        Raises:
            libsumo.TraCIException: SUMO does not know the vehicle.
        """
        front = x + 0.5 * length * math.cos(yaw), y + 0.5 * length * math.sin(yaw)
        placed = self._vehicles.setdefault(name, _Placed())
        placed.pose, placed.speed = (*front, yaw), speed
        self._move(name, placed)

    def forget(self, name: str) -> None:
        """Leave a vehicle to SUMO: it is not placed again, or is removed."""
        self._vehicles.pop(name, None)

    def restore_arrived(self) -> list[str]:
        """Insert the vehicles again that arrived in the last step; return their names."""
        names = [name for name in libsumo.simulation.getArrivedIDList() if name in self._vehicles]
        restored: list[str] = []
        for name in names:
            placed = self._vehicles.pop(name)
            if placed.kind:
                self.insert(name, placed.kind, placed.edges)
                again = self._vehicles[name]
                again.pose, again.speed = placed.pose, placed.speed
                self._move(name, again)
                restored.append(name)
        return restored

    def clear_shadows(self, lanes: Mapping[str, tuple[str, float]]) -> None:
        """Clear the registrations of vehicles that have left their lane for no other.

        Args:
            lanes: Lane and position on it of the vehicles in view, by name; others are looked up.
        """
        for name, placed in self._vehicles.items():
            lane, position = lanes.get(name, ("", 0.0))
            if lane:
                placed.lane, placed.lane_position = lane, position
            elif placed.lane:
                if not libsumo.vehicle.getLaneID(name):
                    self._reseat(name, placed)
                placed.lane = ""

    def _move(self, name: str, placed: _Placed) -> None:
        x, y, yaw = placed.pose
        angle = 90.0 - math.degrees(yaw)
        libsumo.vehicle.moveToXY(name, "", 0, x, y, angle, 2, MATCH_RADIUS)
        libsumo.vehicle.setSpeed(name, placed.speed)

    def _reseat(self, name: str, placed: _Placed) -> None:
        """Move a vehicle that is on no lane to another lane than its last one, and back."""
        for other in self._other_lanes(name, placed.lane):
            with contextlib.suppress(libsumo.TraCIException):  # it may not be on the route
                libsumo.vehicle.moveTo(name, other, 0.0)
                libsumo.vehicle.moveTo(name, placed.lane, placed.lane_position)
                return

    def _other_lanes(self, name: str, lane: str) -> Iterable[str]:
        edge, _, index = lane.rpartition("_")
        if libsumo.edge.getLaneNumber(edge) > 1:
            yield f"{edge}_{1 if index == '0' else int(index) - 1}"
        for other in libsumo.vehicle.getRoute(name):
            if other != edge:
                yield f"{other}_0"
