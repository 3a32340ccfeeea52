"""A vehicle is rerouted only while it can still change its route."""

import random

import numpy as np
import pytest

from plant_bench.sim.hazards.conflicting_vehicle import reroute
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.sumo import VehicleState
from plant_bench.sim.vehicle_types import VEHICLE_TYPES, VehicleType
from plant_bench.world.conflicting_paths import Approach
from plant_bench.world.scene import ActorKind
from plant_bench.world.town import load_town

BUS = next(kind for kind in VEHICLE_TYPES if kind.kind is ActorKind.BUS)
TOWN = load_town("town02")
LINK = next(link for link in TOWN.links if link.control == "signal" and link.via)
LANE = TOWN.lanes[LINK.source]
APPROACH = Approach(
    link=LINK,
    line=LANE.points[:, :2],
    starts={LANE.id: 0.0},
    edges=(LANE.edge, TOWN.lanes[LINK.target].edge),
    stop=LANE.length,
    meets=LANE.length,
    at=0.0,
    clear=0.0,
    angle=0.0,
)


class OneVehicle(HazardWorld):
    def __init__(self, left: float, speed: float) -> None:
        self.town = TOWN
        self.asked: list[tuple[str, ...]] = []
        self.sent: list[tuple[str, ActorKind]] = []
        x, y, z = np.append(LANE.points[-1], 0.0)[:3].tolist()
        self._state = VehicleState(x, y, z, 0.0, speed, 0.0, LANE.id, LANE.length - left, 0.0)

    def state_of(self, vehicle: int) -> VehicleState:
        return self._state

    def along_lane(self, state: VehicleState) -> float:
        return state.lane_position

    def kind_of(self, actor: int) -> VehicleType:
        return BUS

    def onward(self, edge: str, kind: ActorKind, draw: random.Random) -> list[str]:
        self.sent.append((edge, kind))
        return ["onward"]

    def reroute(self, vehicle: int, edges: tuple[str, ...]) -> bool:
        self.asked.append(edges)
        return True


@pytest.mark.parametrize(("left", "speed"), [(30.0, 10.0), (1.0, 0.0), (4.0, 5.0)])
def test_vehicle_before_its_turn_is_rerouted(left, speed):
    world = OneVehicle(left, speed)
    assert reroute(world, APPROACH, 1, random.Random(1))
    assert world.asked == [(*APPROACH.edges, "onward")]
    assert world.sent == [(APPROACH.edges[-1], ActorKind.BUS)]


@pytest.mark.parametrize(("left", "speed"), [(2.0, 10.0), (0.5, 1.0), (0.1, 0.0)])
def test_vehicle_about_to_leave_its_lane_is_not_rerouted(left, speed):
    world = OneVehicle(left, speed)
    assert not reroute(world, APPROACH, 1, random.Random(1))
    assert not world.asked
