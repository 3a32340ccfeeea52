"""Vehicles that are placed with moveToXY: the ego, hazards' actors and proxies of pedestrians.

SUMO goes on driving a placed vehicle between two placements, and has three faults:

- A vehicle that reaches the end of its route arrives and is removed; the next placement fails
  (eclipse-sumo/sumo issues 3993 and 4250). Such a vehicle is inserted again at once.
- A vehicle that is placed off all lanes stays registered on a lane beside its last ones, if it
  overlapped that lane when SUMO put it on its last lane. Sorting that lane's vehicles then reads an
  empty vector, and the process dies. Moving the vehicle to another lane and back removes the
  registration.
- A vehicle that is moved sideways on its lane is registered on the lane beside it neither when it
  begins to overlap that lane nor when it ends to: drivers there go through it, or wait for nobody.
  Moving it to that lane for an instant makes SUMO insert it anew where it is placed.
"""

import contextlib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from plant_bench.sim.sumo_library import libsumo

MATCH_RADIUS = (
    8.0  # m around a position in which SUMO looks for its lane; the default costs 4 times
)
OVERLAP = 0.05  # m by which a vehicle reaches beyond its lane before it counts
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
        width: Its width, metres.
        side: Where it overlapped the lane beside its own when SUMO last inserted it: 1 to the
            left, -1 to the right, 0 if it did not.
        jump: Lane to which it is moved before it is next placed; "" for none.
    """

    kind: str = ""
    edges: tuple[str, ...] = ()
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: float = 0.0
    lane: str = ""
    lane_position: float = 0.0
    width: float = 0.0
    side: int = 0
    jump: str = ""


class Placements:
    """The placed vehicles of a running simulation, by SUMO's names; mutable."""

    def __init__(self) -> None:
        self._vehicles: dict[str, _Placed] = {}
        self._inserted = 0
        self._widths: dict[str, float] = {}  # of lanes, metres
        self._lane_counts: dict[str, int] = {}  # of edges

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
        if placed.jump:
            with contextlib.suppress(libsumo.TraCIException):  # it may not be on the route
                libsumo.vehicle.moveTo(name, placed.jump, placed.lane_position)
            placed.jump = ""
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

    def refresh(self, lanes: Mapping[str, tuple[str, float, float]]) -> None:
        """Correct the lanes on which SUMO has the vehicles; call after each step.

        Args:
            lanes: Lane, position on it, and lateral offset from its centre (positive to the left),
                metres, of the vehicles in view, by name; others are looked up.
        """
        for name, placed in self._vehicles.items():
            lane, position, lateral = lanes.get(name, ("", 0.0, 0.0))
            if lane:
                side = self._overlapped_side(name, placed, lane, lateral)
                if lane != placed.lane:  # inserted there by this step, with the right overlap
                    placed.side = side
                elif side != placed.side:
                    placed.jump = self._lane_beside(lane, side or placed.side)
                    placed.side = side
                placed.lane, placed.lane_position = lane, position
            elif placed.lane:
                if not libsumo.vehicle.getLaneID(name):
                    self._reseat(name, placed)
                placed.lane, placed.jump = "", ""

    def _overlapped_side(self, name: str, placed: _Placed, lane: str, lateral: float) -> int:
        """Return on which side a vehicle reaches beyond its lane: 1 left, -1 right, 0 neither."""
        if not placed.width:
            placed.width = libsumo.vehicle.getWidth(name)
        if lane not in self._widths:
            self._widths[lane] = libsumo.lane.getWidth(lane)
        if abs(lateral) + 0.5 * placed.width < 0.5 * self._widths[lane] + OVERLAP:
            return 0
        return 1 if lateral > 0.0 else -1

    def _lane_beside(self, lane: str, side: int) -> str:
        """Return the lane to the left (1) or right (-1) of a lane; "" if there is none."""
        edge, _, index = lane.rpartition("_")
        if edge.startswith(":"):
            return ""  # lanes inside a junction lie over each other
        if edge not in self._lane_counts:
            self._lane_counts[edge] = libsumo.edge.getLaneNumber(edge)
        beside = int(index) + side
        return f"{edge}_{beside}" if 0 <= beside < self._lane_counts[edge] else ""

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
