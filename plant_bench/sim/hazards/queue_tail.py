"""The tail of a slow or standing queue on the ego's lane, beyond a curve or met at speed.

The cars are put out beyond the ego's sight and drive off when the ego has stopped behind them, or
after some seconds.
"""

import random

from plant_bench.sim.hazards.behaviour import number_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import CAR
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

GAP = 3.0  # m between the cars that stand
FEWEST = 2  # cars that are a queue
NEAR = 25.0  # m behind the tail within which an ego that stands has met it
MET = 60.0  # m behind the tail from which on the queue's time runs
LONGEST = 60.0  # s for which the queue stands at the most
PASSED = 30.0  # m behind the ego at which the queue is done
STANDING = 0.5  # m/s
TRY_EVERY = 4  # ticks between two tries to put the cars out


class QueueTail:
    """Some cars that stand or crawl; mutable.

    Parameters: `cars` (3 to 6), `speed` (m/s, 0 for a standing queue), `wait` (s from the ego's
    coming until they drive off), `pause` (s that the ego stands behind them until they do).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        parameters = hazard.parameters
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._speed = parameters.get("speed", 0.0)
        self._wait = number_of(hazard, "wait", draw)
        self._pause = number_of(hazard, "pause", draw)
        count = int(parameters.get("cars", draw.randint(3, 6)))
        self._fronts = [hazard.at + CAR.length + k * (CAR.length + GAP) for k in range(count)]
        self._lane = stage.lane_at(hazard.at)
        self._cars: dict[float, int] = {}
        self._placed = 0.0
        self._met: float | None = None
        self._stood: float | None = None

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Put the cars out, hold them, let them drive off."""
        if self.phase is Phase.ARMED:
            self._appear(stage)
        elif self._over(ego, stage):
            self._end(stage, Phase.DONE)

    def _appear(self, stage: HazardWorld) -> None:
        cars = {front: car for front, car in self._cars.items() if stage.on_road(car)}
        missing = [front for front in self._fronts if front not in cars]
        hidden = stage.out_of_sight(self._at)
        for car in cars.values():
            stage.drive(car, self._speed)
        if (not hidden or not missing) and len(cars) >= FEWEST:
            self.phase, self._placed = Phase.COMMITTED, stage.time
        elif not hidden:
            self._end(stage, Phase.VOID, "there was no room for a queue")
        elif stage.tick % TRY_EVERY == 0 and self._lane is not None:
            for front in reversed(missing):
                car = stage.send_along(CAR, self._lane, front, 0.0)
                if car is not None:
                    cars[front] = car
        self._cars = cars

    def _over(self, ego: EgoState, stage: HazardWorld) -> bool:
        distance, now = self._distance(stage), stage.time
        if self._met is None and (distance < MET or ego.speed < STANDING):
            self._met = now
        stands = ego.speed < STANDING and distance < NEAR
        if stands and self._stood is None:
            self._stood = now
        return (
            distance < -PASSED - (self._fronts[-1] - self._fronts[0])
            or (self._stood is not None and now - self._stood > self._pause)
            or (self._met is not None and now - self._met > self._wait)
            or now - self._placed > LONGEST
        )

    def _distance(self, stage: HazardWorld) -> float:
        """Return the metres from the ego to the tail, which crawls on."""
        return stage.distance_to(self._at) + self._speed * (stage.time - self._placed)

    def _end(self, stage: HazardWorld, phase: Phase, reason: str = "") -> None:
        for car in self._cars.values():
            stage.hand_back(car)
        self.phase, self.reason = phase, reason
