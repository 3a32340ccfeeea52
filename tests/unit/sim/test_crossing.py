"""Crossing: the van that hides a pedestrian stands clear of all lanes."""

import random
from types import SimpleNamespace

import numpy as np
import pytest

from plant_bench.geometry.box import corners
from plant_bench.sim.hazards.crossing import VAN_BEFORE, Crossing
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.vehicle_types import VAN, VehicleType
from plant_bench.world.hazard import Hazard, HazardKind
from tests.builders import make_ego, make_lane, straight_route

AT = 120.0  # m along the route, where the pedestrian crosses
CLEARANCE = 0.15  # m between the van and the lanes


class StraightRoad(HazardWorld):
    """A road along +x whose lanes have given widths; the ego drives on the first one."""

    def __init__(self, widths: tuple[float, ...]) -> None:
        self.route = straight_route(300)
        self.progress, self.tick = 0.0, 0
        self.put_at: dict[str, tuple[float, float, float]] = {}
        lanes, right = {}, 0.5 * widths[0]
        for number, width in enumerate(widths):
            middle = 0.0 if number == 0 else right + 0.5 * width
            right = middle + 0.5 * width
            points = np.array([(x, -middle, 0.0) for x in np.arange(0.0, 301.0, 5.0)])
            lanes[f"e_{number}"] = make_lane(f"e_{number}", points, width=width)
        self.right_edge = right
        self.town = SimpleNamespace(lanes=lanes)  # type: ignore[assignment]

    def pose_at(self, along: float) -> tuple[float, float, float]:
        return along, 0.0, 0.0

    def speed_limit_at(self, along: float) -> float:
        return 10.0

    def distance_to(self, along: float) -> float:
        return along - self.progress

    def is_free(self, x: float, y: float, radius: float) -> bool:
        return True

    def put(self, kind: VehicleType, x: float, y: float, yaw: float) -> int:
        self.put_at[kind.name] = (x, y, yaw)
        return len(self.put_at)


@pytest.mark.parametrize("widths", [(3.2,), (6.0,), (3.5, 3.5), (3.0, 3.27), (4.13,)])
def test_parked_van_of_a_crossing_is_clear_of_the_lanes(widths: tuple[float, ...]) -> None:
    """Also where the road's edge is not a multiple of the steps in which it is searched."""
    world = StraightRoad(widths)
    hazard = Hazard(HazardKind.CROSSING, AT, 60.0, 7, {"side": -1.0, "hidden": 1.0})

    Crossing(hazard, world, random.Random(1)).step(make_ego(10.0), world)

    outline = corners(np.array([world.put_at[VAN.name]]), np.array([[VAN.length, VAN.width]]))[0]
    gap = -world.right_edge - outline[:, 1].max()
    assert CLEARANCE - 1e-6 < gap < 2.0


def test_parked_van_is_clear_of_a_lane_that_ends_between_its_corners() -> None:
    """A narrow side road ends at the middle of the place where the van would stand."""
    world = StraightRoad((3.2,))
    van_at = AT - VAN_BEFORE
    points = np.array([(van_at, y, 0.0) for y in np.linspace(-30.0, -4.2, 60)])
    world.town.lanes["side_0"] = make_lane("side_0", points, width=1.5)
    hazard = Hazard(HazardKind.CROSSING, AT, 60.0, 7, {"side": -1.0, "hidden": 1.0})

    Crossing(hazard, world, random.Random(1)).step(make_ego(10.0), world)

    assert VAN.name not in world.put_at
