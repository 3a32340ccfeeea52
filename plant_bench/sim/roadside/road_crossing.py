"""Rules for when a pedestrian may cross a road: only if vehicles could still stop."""

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from plant_bench.sim.roadside.footways import Crossing
from plant_bench.world.driver_braking import SPARE, stopping_distance
from plant_bench.world.route import Route
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, Actors, EgoState, Light

SPARE_TIME = 1.0  # s between the end of a crossing and the next vehicle
CLEARANCE_TIME = 2.0  # s of a crossing that may be after the light has changed
MIN_GREEN = 4.0  # s of green that suffice for any crossing
MOVING = 0.3  # m/s
COMFORTABLE = 2.5  # m/s2 with which drivers are expected to stop for a red light
BESIDE = 0.6  # m beside a crossing that must be free of vehicles
RIM = 2.0  # m beyond a crossing's ends where a vehicle's path still conflicts


@runtime_checkable
class Lights(Protocol):
    """Queries of traffic lights; implemented by `Signals`."""

    def light(self, signal: str, index: int) -> Light:
        """Return what a signal shows to one of its links."""
        ...

    def time_to_switch(self, signal: str) -> float:
        """Return the seconds until a signal may change."""
        ...


class MovingVehicle(NamedTuple):
    """A vehicle: box centre, heading, speed and size, SI units."""

    x: float
    y: float
    yaw: float
    speed: float
    length: float
    width: float


def moving(actors: Actors) -> list[MovingVehicle]:
    """Return the vehicles of a scene, without parked cars and pedestrians."""
    vehicles = actors.only(actors.in_traffic)
    columns = np.column_stack((vehicles.poses, vehicles.speeds, vehicles.extents))
    return [MovingVehicle(*row) for row in columns.tolist()]


class CrossingRules:
    """Decides whether a pedestrian may cross; mutable only in its cache of the route's crossings.

    Args:
        lights: Lights of the running simulation.
        route: The ego's route.
    """

    def __init__(self, lights: Lights, route: Route) -> None:
        self._lights = lights
        self._route = route
        self._spans: dict[str, tuple[float, float] | None] = {}

    def allowed(
        self,
        crossing: Crossing,
        duration: float,
        ego: EgoState,
        progress: float,
        others: Sequence[MovingVehicle],
    ) -> bool:
        """Tell whether a walker may start to cross now.

        Args:
            crossing: The crossing.
            duration: Time until the walker has left the road, seconds.
            ego: The ego.
            progress: Arc length of the ego on its route, metres.
            others: The vehicles nearby.
        """
        return (
            self._is_green(crossing, duration)
            and self._ego_can_stop(crossing, duration, ego, progress)
            and not any(_conflicts(crossing, duration, other) for other in others)
        )

    def _is_green(self, crossing: Crossing, duration: float) -> bool:
        if crossing.signal is None:
            return True
        if self._lights.light(crossing.signal, crossing.signal_index) is not Light.GREEN:
            return False
        left = self._lights.time_to_switch(crossing.signal)
        return left >= min(duration - CLEARANCE_TIME, MIN_GREEN)

    def _ego_can_stop(
        self, crossing: Crossing, duration: float, ego: EgoState, progress: float
    ) -> bool:
        """Tell whether an ego driver with reaction time could stop."""
        span = self.span(crossing)
        if span is None or progress - 0.5 * EGO_LENGTH > span[1]:
            return True
        distance = span[0] - progress - 0.5 * EGO_LENGTH
        if distance - stopping_distance(ego) < min(SPARE, ego.speed):
            return False
        if crossing.signal is None and ego.speed > MOVING:
            return distance / ego.speed > duration + SPARE_TIME
        return True

    def span(self, crossing: Crossing) -> tuple[float, float] | None:
        """Return the arc lengths at which the route enters and leaves a crossing, or None."""
        if crossing.id not in self._spans:
            self._spans[crossing.id] = _span(self._route, crossing)
        return self._spans[crossing.id]


def _span(route: Route, crossing: Crossing) -> tuple[float, float] | None:
    (ax, ay, az), (bx, by, _) = crossing.points
    length = math.hypot(bx - ax, by - ay)
    ux, uy = (bx - ax) / length, (by - ay) / length
    dx, dy = route.points[:, 0] - ax, route.points[:, 1] - ay
    along, aside = dx * ux + dy * uy, dy * ux - dx * uy
    rim = 0.5 * EGO_WIDTH
    over = (along > -rim) & (along < length + rim)
    over &= np.abs(aside) < 0.5 * crossing.width + 0.5
    over &= np.abs(route.elevations - az) < 3.0
    if not over.any():
        return None
    first = int(np.argmax(over))
    last = first + int(np.argmin(np.append(over[first:], False))) - 1
    return float(route.along[first]), float(route.along[last])


def _conflicts(crossing: Crossing, duration: float, other: MovingVehicle) -> bool:
    """Tell whether a vehicle is on a crossing, or arrives during the walker's crossing."""
    (ax, ay, _), (bx, by, _) = crossing.points
    length = math.hypot(bx - ax, by - ay)
    ux, uy = (bx - ax) / length, (by - ay) / length
    dx, dy = other.x - ax, other.y - ay
    along, aside = dx * ux + dy * uy, dy * ux - dx * uy
    forward = (
        math.sin(other.yaw) * ux - math.cos(other.yaw) * uy
    )  # component of its heading across the crossing
    half = 0.5 * other.length
    reach = abs(forward) * half + 0.5 * crossing.width + BESIDE
    if -half < along < length + half and abs(aside) < reach:
        return True
    if other.speed < MOVING or forward * aside >= 0.0 or abs(forward) < 0.2:
        return False  # stationary, driving away, or parallel
    way = abs(aside / forward)
    met = along + way * (math.cos(other.yaw) * ux + math.sin(other.yaw) * uy)
    distance = way - half - 0.5 * crossing.width
    if not -RIM < met < length + RIM:
        return False
    if crossing.signal is not None:
        return distance < other.speed + other.speed**2 / (2.0 * COMFORTABLE)
    return distance / other.speed < duration + SPARE_TIME
