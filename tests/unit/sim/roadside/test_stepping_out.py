"""A walker steps out only before those who can stop, and into gaps."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.sim.roadside.footways import Crossing
from plant_bench.sim.roadside.road_crossing import CrossingRules, MovingVehicle
from plant_bench.world.route import LaneSpan, Route
from plant_bench.world.scene import EgoState, Light

OVER = Crossing("c", ((100.0, -3.5, 0.0), (100.0, 3.5, 0.0)), 4.0)
SIGNALLED = replace(OVER, id="s", signal="light", signal_index=3)
DURATION = 6.0
STANDING = EgoState(0.0, 0.0, 0.0, 0.0)


class Lights:
    """Stands for SUMO."""

    def __init__(self, shown: Light, left: float) -> None:
        self.shown, self.left = shown, left

    def light(self, signal: str, index: int) -> Light:
        return self.shown

    def time_to_switch(self, signal: str) -> float:
        return self.left


def rules(shown: Light = Light.GREEN, left: float = 20.0) -> CrossingRules:
    points = np.stack((np.arange(200.0), np.full(200, -1.75)), axis=1)
    route = Route(
        "r", "t", points, np.zeros(200), np.full(200, 13.9), ("e",),
        (LaneSpan("e_0", 0.0, 199.0),), (), (), {},
    )  # fmt: skip
    return CrossingRules(Lights(shown, left), route)


def test_the_route_is_known_to_lead_over_a_crossing() -> None:
    assert rules().span(OVER) == pytest.approx((98.0, 102.0), abs=1.0)
    aside = replace(OVER, id="d", points=((100.0, 50.0, 0.0), (100.0, 57.0, 0.0)))
    assert rules().span(aside) is None


@pytest.mark.parametrize("crossing", [OVER, SIGNALLED])
@pytest.mark.parametrize("speed", [3.0, 8.0, 13.9])
def test_never_before_an_ego_that_could_not_stop(crossing: Crossing, speed: float) -> None:
    ego = EgoState(0.0, 0.0, 0.0, speed)
    stop = 0.5 * speed + speed**2 / 8.0
    too_near = 98.0 - 2.45 - stop - 0.5
    assert not rules().allowed(crossing, DURATION, ego, too_near, [])
    behind = 102.0 + 2.45 + 2.0
    assert rules().allowed(crossing, DURATION, ego, behind, [])


def test_before_an_ego_that_can_stop_only_at_a_light() -> None:
    ego = EgoState(0.0, 0.0, 0.0, 8.0)
    assert rules().allowed(SIGNALLED, DURATION, ego, 70.0, [])
    assert not rules().allowed(OVER, DURATION, ego, 70.0, [])
    assert rules().allowed(OVER, DURATION, ego, 20.0, [])  # a gap


def test_not_while_the_ego_stands_on_it() -> None:
    assert not rules().allowed(OVER, DURATION, STANDING, 99.0, [])
    assert rules().allowed(OVER, DURATION, STANDING, 90.0, [])


def test_lights_are_kept_and_must_last() -> None:
    ask = (SIGNALLED, DURATION, STANDING, 0.0, [])
    assert rules(Light.GREEN, 4.0).allowed(*ask)
    assert not rules(Light.GREEN, 2.0).allowed(*ask)
    assert not rules(Light.RED).allowed(*ask)


@pytest.mark.parametrize(
    ("other", "free"),
    [
        (MovingVehicle(60.0, 1.0, 0.0, 10.0, 4.5, 1.8), False),  # arrives soon
        (MovingVehicle(140.0, 1.0, 3.14159, 10.0, 4.5, 1.8), False),  # from the other side too
        (MovingVehicle(60.0, 1.0, 3.14159, 10.0, 4.5, 1.8), True),  # drives away
        (MovingVehicle(10.0, 1.0, 0.0, 10.0, 4.5, 1.8), True),  # far enough
        (MovingVehicle(90.0, 1.0, 0.0, 0.0, 4.5, 1.8), True),  # has stopped for them
        (MovingVehicle(100.0, 1.0, 0.0, 0.0, 4.5, 1.8), False),  # stands on it
        (MovingVehicle(90.0, 30.0, 0.0, 10.0, 4.5, 1.8), True),  # another street
    ],
)
def test_gaps_between_vehicles(other: MovingVehicle, free: bool) -> None:
    assert rules().allowed(OVER, DURATION, STANDING, 0.0, [other]) is free
