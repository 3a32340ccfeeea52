"""Unprotected left turn (CARLA type 8): oncoming vehicles take their right of way.

The first conflicts with the ego; others follow in a stream with one gap long enough to turn.
"""

import random

from plant_bench.sim.hazards.conflicting_vehicle import (
    MIN_RUN,
    ConflictingVehicle,
    incoming,
    place_on,
    spawn_on,
)
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.hazards.junction_conflict import PASSED, JunctionConflict
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

TURNED = -8.0  # m to the conflict point at which the ego has turned
LOOK = 4  # ticks between two queries of the stream
ENDED = (Phase.DONE, Phase.VOID)


class UnprotectedLeft(JunctionConflict):
    """A stream of oncoming vehicles with the right of way; mutable.

    Parameters: `speed` (m/s), `vehicles` (total number), `gap` (s from front to front), `long_gap`
    (s, before the last one).
    """

    ignores_rules = False
    waiting_tolerance = 2.5

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        super().__init__(hazard, world, draw)
        parameters = hazard.parameters
        count = int(parameters.get("vehicles", draw.randint(2, 4)))
        gap = parameters.get("gap", 2.4)
        self._gaps = [gap * draw.uniform(1.0, 1.4) for _ in range(count - 1)]
        if self._gaps:
            self._gaps[-1] = parameters.get("long_gap", 7.0)
        self.vehicles: list[int] = []

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Let the stream follow the first vehicle; release all when the ego has turned."""
        super().step(ego, world)
        if self.conflicting is not None and self.phase not in ENDED:
            world.ignore_ego(self.conflicting.vehicle, on=True)
            self._follow(world, self.conflicting)

    def over(self, world: HazardWorld, conflicting: ConflictingVehicle) -> bool:
        """Tell whether the ego has turned, or the whole stream has passed."""
        if world.distance_to(conflicting.approach.at) < TURNED:
            return True
        return super().over(world, conflicting) and not self.vehicles and not self._gaps

    def let_go(self, world: HazardWorld) -> None:
        """Return the stream to the traffic."""
        if self.conflicting is not None:
            world.ignore_ego(self.conflicting.vehicle, on=False)
        for vehicle in [*self.vehicles]:
            self._release(world, vehicle)
        super().let_go(world)

    def _release(self, world: HazardWorld, vehicle: int) -> None:
        world.ignore_ego(vehicle, on=False)
        world.release(vehicle)
        self.vehicles.remove(vehicle)

    def _follow(self, world: HazardWorld, conflicting: ConflictingVehicle) -> None:
        way = conflicting.approach
        places = [place_on(world, way, vehicle) for vehicle in self.vehicles]
        for vehicle, place in zip([*self.vehicles], places, strict=True):
            if place is None or place > way.meets + PASSED:
                self._release(world, vehicle)
        if world.tick % LOOK == 0:
            for lane in incoming(way):
                for vehicle, _, _ in world.lane_state(lane):
                    known = world.is_commanded(vehicle)
                    if not known and world.next_via(vehicle) == way.link.via[0]:
                        self._join(world, vehicle)
        known = [place for place in (*places, conflicting.front(world)) if place is not None]
        if self._gaps and world.tick % LOOK == 0:
            nearest = min(known, default=way.meets)
            to_go = way.meets - nearest + self._gaps[0] * self._speed
            vehicle = spawn_on(world, way, max(to_go, MIN_RUN), self._speed, self._draw)
            if vehicle is not None:
                self._gaps.pop(0)
                self._join(world, vehicle)

    def _join(self, world: HazardWorld, vehicle: int) -> None:
        world.command(vehicle)
        world.ignore_ego(vehicle, on=True)
        self.vehicles.append(vehicle)
