"""A van stands in the ego's lane, with the traffic of the lane beside it, and drives off later.

A planner that cannot overtake only loses time. The van is put out on an empty spot out of the ego's
sight and shortly before it arrives, so that few others must queue behind it.
"""

import random

from plant_bench.sim.hazards.behaviour import number_of
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import VAN
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

ARRIVED = 40.0  # m before the van from which on the ego waits for it
QUEUED = 120.0  # m before the van within which an ego that stands waits in its queue, if no
# junction lies between them
LONGEST = 90.0  # s for which a van stands at the most
PASSED = 30.0  # m behind the ego at which the van is done
TRY_EVERY = 4  # ticks between two tries to put it out


class BlockedLane:
    """One van that stands; mutable.

    Parameters: `wait` (s from the ego's arrival until it drives off).
    """

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        self.phase = Phase.ARMED
        self.reason = ""
        self._at = hazard.at
        self._wait = number_of(hazard, "wait", draw)
        self._lane = stage.lane_at(hazard.at)
        self._van: int | None = None
        self._placed = 0.0
        self._arrived: float | None = None

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Put the van out, let the ego wait, drive off."""
        if self.phase is Phase.ARMED:
            self._appear(stage)
            return
        distance = stage.distance_to(self._at)
        waits = distance < ARRIVED or (ego.speed < 0.5 and self._queues(distance, stage))
        if waits and self._arrived is None:
            self._arrived = stage.time
        waited = stage.time - self._arrived if self._arrived is not None else 0.0
        passed = distance < -PASSED - VAN.length
        if passed or waited > self._wait or stage.time - self._placed > LONGEST:
            self._end(stage, Phase.DONE)

    def _queues(self, distance: float, stage: HazardWorld) -> bool:
        entries = [passage.entry for passage in stage.route.passages]
        return distance < QUEUED and not any(stage.progress < x < self._at for x in entries)

    def _appear(self, stage: HazardWorld) -> None:
        if self._van is not None and stage.on_road(self._van):
            stage.drive(self._van, 0.0)
            self.phase, self._placed = Phase.COMMITTED, stage.time
        elif self._lane is None:
            self._end(stage, Phase.VOID, "there is no lane outside junctions")
        elif not stage.out_of_sight(self._at):
            self._end(stage, Phase.VOID, "the spot was taken")
        elif stage.tick % TRY_EVERY == 0:
            front = self._at + VAN.length
            self._van = stage.send_along(VAN, self._lane, front, 0.0)

    def _end(self, stage: HazardWorld, phase: Phase, reason: str = "") -> None:
        if self._van is not None:
            stage.hand_back(self._van)
        self.phase, self.reason = phase, reason
