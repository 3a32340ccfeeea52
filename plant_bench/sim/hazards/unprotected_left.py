"""An unprotected left turn (CARLA type 8): oncoming vehicles insist, the ego turns on green.

The first meets the ego; others follow it in a stream with one gap that is long enough to turn.
"""

import random

from plant_bench.sim.hazards.conflicting_vehicle import (
    LEAST_RUN,
    ConflictingVehicle,
    incoming,
    place_on,
    put_out,
)
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.hazards.junction_conflict import PASSED, JunctionConflict
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.scene import EgoState

TURNED = -8.0  # m to the meeting place at which the ego has turned
LOOK = 4  # ticks between two looks at the stream
ENDED = (Phase.DONE, Phase.VOID)


class UnprotectedLeft(JunctionConflict):
    """A stream of oncoming vehicles with the right of way; mutable.

    Parameters: `speed` (m/s), `vehicles` (in all), `gap` (s from front to front), `long_gap` (s,
    before the last one).
    """

    lawless = False
    forestalls = 2.5

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        super().__init__(hazard, stage, draw)
        parameters = hazard.parameters
        count = int(parameters.get("vehicles", draw.randint(2, 4)))
        gap = parameters.get("gap", 2.4)
        self._gaps = [gap * draw.uniform(1.0, 1.4) for _ in range(count - 1)]
        if self._gaps:
            self._gaps[-1] = parameters.get("long_gap", 7.0)
        self.vehicles: list[int] = []

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Let the stream follow the first vehicle; all are let go when the ego has turned."""
        super().step(ego, stage)
        if self.rival is not None and self.phase not in ENDED:
            stage.unforgiving(self.rival.vehicle, on=True)
            self._follow(stage, self.rival)

    def over(self, stage: HazardWorld, rival: ConflictingVehicle) -> bool:
        """Tell whether the ego has turned, or the whole stream has passed."""
        if stage.distance_to(rival.approach.at) < TURNED:
            return True
        return super().over(stage, rival) and not self.vehicles and not self._gaps

    def let_go(self, stage: HazardWorld) -> None:
        """Give the stream back to the traffic."""
        if self.rival is not None:
            stage.unforgiving(self.rival.vehicle, on=False)
        for vehicle in [*self.vehicles]:
            self._let_go(stage, vehicle)
        super().let_go(stage)

    def _let_go(self, stage: HazardWorld, vehicle: int) -> None:
        stage.unforgiving(vehicle, on=False)
        stage.release(vehicle)
        self.vehicles.remove(vehicle)

    def _follow(self, stage: HazardWorld, rival: ConflictingVehicle) -> None:
        way = rival.approach
        places = [place_on(stage, way, vehicle) for vehicle in self.vehicles]
        for vehicle, place in zip([*self.vehicles], places, strict=True):
            if place is None or place > way.meets + PASSED:
                self._let_go(stage, vehicle)
        if stage.tick % LOOK == 0:
            for lane in incoming(way):
                for vehicle, _, _ in stage.lane_state(lane):
                    known = stage.is_commanded(vehicle)
                    if not known and stage.next_via(vehicle) == way.link.via[0]:
                        self._join(stage, vehicle)
        known = [place for place in (*places, rival.front(stage)) if place is not None]
        if self._gaps and stage.tick % LOOK == 0:
            nearest = min(known, default=way.meets)
            to_go = way.meets - nearest + self._gaps[0] * self._speed
            vehicle = put_out(stage, way, max(to_go, LEAST_RUN), self._speed, self._draw)
            if vehicle is not None:
                self._gaps.pop(0)
                self._join(stage, vehicle)

    def _join(self, stage: HazardWorld, vehicle: int) -> None:
        stage.command(vehicle)
        stage.unforgiving(vehicle, on=True)
        self.vehicles.append(vehicle)
