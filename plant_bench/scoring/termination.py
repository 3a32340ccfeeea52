"""Episode termination: completed, deviated, blocked or timed out (CARLA leaderboard 1.0)."""

import math

from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.world.route import Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import TICK, EgoState

# Sources: scenario_runner 1.0, atomic_criteria.py, and leaderboard 1.0, route_scenario.py.
COMPLETED_SHARE = 0.99  # RouteCompletionTest: more than 99 % of the route ...
COMPLETED_RADIUS = 10.0  # m: ... and this close to the destination (RouteCompletionTest)
BLOCKED_SPEED = 0.1  # m/s (ActorSpeedAboveThresholdTest, as route_scenario.py sets it)
BLOCKED_TIME = 180.0  # s (ActorSpeedAboveThresholdTest, as route_scenario.py sets it)
DEVIATION_LIMIT = 30.0  # m (InRouteTest, offroad_max)
DEVIATION_NEAR = 15.0  # m (InRouteTest, offroad_min)
DEVIATION_SHARE = 0.30  # of the route's length, driven beyond DEVIATION_NEAR (InRouteTest)
TIMEOUT_PER_METRE = 0.8  # s/m (route_scenario.py, SECONDS_GIVEN_PER_METERS)
TIMEOUT_EXTRA = 5.0  # s (route_scenario.py, INITIAL_SECONDS_DELAY)

ENDING_INFRACTIONS = {
    Status.DEVIATED: InfractionKind.ROUTE_DEVIATION,
    Status.BLOCKED: InfractionKind.BLOCKED,
    Status.TIMED_OUT: InfractionKind.TIMEOUT,
}


class Termination:
    """Checks at each tick whether the episode ends; mutable.

    Args:
        route: The route to be driven.
    """

    def __init__(self, route: Route) -> None:
        self._length = route.length
        self._x, self._y = (float(value) for value in route.points[-1])
        timeout = int(TIMEOUT_PER_METRE * route.length + TIMEOUT_EXTRA)
        self._timeout_tick = round(timeout / TICK)
        self._blocked_ticks = round(BLOCKED_TIME / TICK)
        self._last_moving: int | None = None
        self._far_distance = 0.0

    def check(self, tick: int, ego: EgoState, place: RouteProgress, step: float) -> Status | None:
        """Return how the episode ends at this tick, None while it continues.

        Args:
            tick: The scene's tick.
            ego: The ego vehicle.
            place: Its position on the route.
            step: Metres driven since the last tick.
        """
        if self._last_moving is None or ego.speed >= BLOCKED_SPEED:
            self._last_moving = tick
        if place.distance > DEVIATION_NEAR:
            self._far_distance += step
        if self._completed(ego, place):
            return Status.COMPLETED
        if place.distance >= DEVIATION_LIMIT or self._far_distance > DEVIATION_SHARE * self._length:
            return Status.DEVIATED
        if tick - self._last_moving > self._blocked_ticks:
            return Status.BLOCKED
        if tick > self._timeout_tick:
            return Status.TIMED_OUT
        return None

    def _completed(self, ego: EgoState, place: RouteProgress) -> bool:
        if place.progress <= COMPLETED_SHARE * self._length:
            return False
        return math.hypot(ego.x - self._x, ego.y - self._y) < COMPLETED_RADIUS
