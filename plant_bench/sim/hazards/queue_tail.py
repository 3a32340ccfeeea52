"""Queue tail: a slow or stationary queue on the ego's lane, behind a curve or at high speed.

The cars are spawned out of the ego's sight and drive off when the ego has stopped behind them, or
after some seconds.
"""

import random

from plant_bench.sim.hazards.behaviour import parameter_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

GAP = 3.0  # m between the cars
MIN_CARS = 2  # cars that count as a queue
NEAR = 25.0  # m behind the tail within which a stationary ego waits in the queue
MET = 60.0  # m behind the tail at which the queue's waiting time starts
MAX_DURATION = 60.0  # s that the queue remains
PASSED = 30.0  # m behind the ego at which the hazard ends
STOPPED_SPEED = 0.5  # m/s
TRY_EVERY = 4  # ticks between two attempts to spawn the cars


class QueueTail:
    """Some stationary or slow cars; mutable.

    Parameters: `cars` (3 to 6), `speed` (m/s, 0 for a stationary queue), `wait` (s from the ego's
    arrival until they drive off), `pause` (s that the ego is stationary behind them until then).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._speed = parameters.get("speed", 0.0)
        self._wait = parameter_of(hazard, "wait", draw)
        self._pause = parameter_of(hazard, "pause", draw)
        count = int(parameters.get("cars", draw.randint(3, 6)))
        self._fronts = [hazard.at + CAR.length + k * (CAR.length + GAP) for k in range(count)]
        self._lane = world.lane_at(hazard.at)
        self._cars: dict[float, int] = {}
        self._placed = 0.0
        self._met: float | None = None
        self._stood: float | None = None

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Spawn the cars, hold them, let them drive off."""
        if self.phase is Phase.ARMED:
            self._appear(world)
        elif self._is_over(ego, world):
            self._end(world, Phase.DONE)

    def _appear(self, world: HazardWorld) -> None:
        cars = {front: car for front, car in self._cars.items() if world.on_road(car)}
        missing = [front for front in self._fronts if front not in cars]
        hidden = world.out_of_sight(self._at)
        for car in cars.values():
            world.drive(car, self._speed)
        if (not hidden or not missing) and len(cars) >= MIN_CARS:
            self.phase, self._placed = Phase.COMMITTED, world.time
        elif not hidden:
            self._end(world, Phase.VOID, "there was no space for a queue")
        elif world.tick % TRY_EVERY == 0 and self._lane is not None:
            for front in reversed(missing):
                car = world.send_along(CAR, self._lane, front, 0.0)
                if car is not None:
                    cars[front] = car
        self._cars = cars

    def _is_over(self, ego: EgoState, world: HazardWorld) -> bool:
        distance, now = self._distance(world), world.time
        if self._met is None and (distance < MET or ego.speed < STOPPED_SPEED):
            self._met = now
        stands = ego.speed < STOPPED_SPEED and distance < NEAR
        if stands and self._stood is None:
            self._stood = now
        return (
            distance < -PASSED - (self._fronts[-1] - self._fronts[0])
            or (self._stood is not None and now - self._stood > self._pause)
            or (self._met is not None and now - self._met > self._wait)
            or now - self._placed > MAX_DURATION
        )

    def _distance(self, world: HazardWorld) -> float:
        """Return the distance from the ego to the moving tail, metres."""
        return world.distance_to(self._at) + self._speed * (world.time - self._placed)

    def _end(self, world: HazardWorld, phase: Phase, reason: str = "") -> None:
        for car in self._cars.values():
            world.hand_back(car)
        self.phase, self.reason = phase, reason
