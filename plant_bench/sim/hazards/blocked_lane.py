"""Blocked lane: a stationary van in the ego's lane drives off some time after the ego arrives.

A planner that cannot overtake only loses time. The van is spawned out of the ego's sight, shortly
before the ego arrives, so that few other vehicles queue behind it.
"""

import random

from plant_bench.sim.hazards.behaviour import parameter_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import VAN
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

ARRIVED = 40.0  # m before the van; the ego waits for it from there on
QUEUED = 120.0  # m before the van; a stationary ego waits in its queue, if no junction lies
# between them
MAX_DURATION = 90.0  # s that the van is stationary
PASSED = 30.0  # m behind the ego at which the hazard ends
TRY_EVERY = 4  # ticks between two attempts to spawn the van


class BlockedLane:
    """One stationary van; mutable.

    Parameters: `wait` (s from the ego's arrival until the van drives off).
    """

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._wait = parameter_of(hazard, "wait", draw)
        self._lane = world.lane_at(hazard.at)
        self._van: int | None = None
        self._placed = 0.0
        self._arrived: float | None = None

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Spawn the van, keep it stationary until the wait is over, and release it."""
        if self.phase is Phase.ARMED:
            self._appear(world)
            return
        distance = world.distance_to(self._at)
        waits = distance < ARRIVED or (ego.speed < 0.5 and self._queues(distance, world))
        if waits and self._arrived is None:
            self._arrived = world.time
        waited = world.time - self._arrived if self._arrived is not None else 0.0
        passed = distance < -PASSED - VAN.length
        if passed or waited > self._wait or world.time - self._placed > MAX_DURATION:
            self._end(world, Phase.DONE)

    def _queues(self, distance: float, world: HazardWorld) -> bool:
        entries = [passage.entry for passage in world.route.passages]
        return distance < QUEUED and not any(world.progress < x < self._at for x in entries)

    def _appear(self, world: HazardWorld) -> None:
        if self._van is not None and world.on_road(self._van):
            world.drive(self._van, 0.0)
            self.phase, self._placed = Phase.COMMITTED, world.time
        elif self._lane is None:
            self._end(world, Phase.VOID, "there is no lane outside junctions")
        elif not world.out_of_sight(self._at):
            self._end(world, Phase.VOID, "the place was occupied")
        elif world.tick % TRY_EVERY == 0:
            front = self._at + VAN.length
            self._van = world.send_along(VAN, self._lane, front, 0.0)

    def _end(self, world: HazardWorld, phase: Phase, reason: str = "") -> None:
        if self._van is not None:
            world.hand_back(self._van)
        self.phase, self.reason = phase, reason
