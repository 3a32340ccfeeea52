"""A pedestrian steps out only before vehicles that can stop, and into gaps."""

from dataclasses import replace

import pytest

from plant_bench.sim.roadside.footways import Crossing
from plant_bench.sim.roadside.road_crossing import CrossingRules, MovingVehicle
from plant_bench.world.scene import Light
from tests.builders import make_ego, straight_route

OVER = Crossing("c", ((100.0, -3.5, 0.0), (100.0, 3.5, 0.0)), 4.0)
SIGNALLED = replace(OVER, id="s", signal="light", signal_index=3)
DURATION = 6.0
STANDING = make_ego()


class Lights:
    """A stub for SUMO's traffic lights."""

    def __init__(self, shown: Light, left: float) -> None:
        self.shown, self.left = shown, left

    def light(self, signal: str, index: int) -> Light:
        return self.shown

    def time_to_switch(self, signal: str) -> float:
        return self.left


def rules(shown: Light = Light.GREEN, left: float = 20.0) -> CrossingRules:
    route = straight_route(199, start=(0.0, -1.75), speed_limit=13.9)
    return CrossingRules(Lights(shown, left), route)


def test_crossing_on_the_route_has_a_span() -> None:
    assert rules().span(OVER) == pytest.approx((98.0, 102.0), abs=1.0)
    aside = replace(OVER, id="d", points=((100.0, 50.0, 0.0), (100.0, 57.0, 0.0)))
    assert rules().span(aside) is None


@pytest.mark.parametrize("crossing", [OVER, SIGNALLED])
@pytest.mark.parametrize("speed", [3.0, 8.0, 13.9])
def test_pedestrian_does_not_step_out_if_the_ego_cannot_stop(
    crossing: Crossing, speed: float
) -> None:
    ego = make_ego(speed)
    stop = 0.5 * speed + speed**2 / 8.0
    too_near = 98.0 - 2.45 - stop - 0.5
    assert not rules().allowed(crossing, DURATION, ego, too_near, [])
    behind = 102.0 + 2.45 + 2.0
    assert rules().allowed(crossing, DURATION, ego, behind, [])


def test_pedestrian_steps_out_before_a_stopping_ego_only_at_a_light() -> None:
    ego = make_ego(8.0)
    assert rules().allowed(SIGNALLED, DURATION, ego, 70.0, [])
    assert not rules().allowed(OVER, DURATION, ego, 70.0, [])
    assert rules().allowed(OVER, DURATION, ego, 20.0, [])  # a gap


def test_pedestrian_does_not_step_out_while_the_ego_is_on_the_crossing() -> None:
    assert not rules().allowed(OVER, DURATION, STANDING, 99.0, [])
    assert rules().allowed(OVER, DURATION, STANDING, 90.0, [])


def test_pedestrian_needs_a_green_light_that_lasts() -> None:
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
def test_pedestrian_steps_out_in_gaps_between_vehicles(other: MovingVehicle, free: bool) -> None:
    assert rules().allowed(OVER, DURATION, STANDING, 0.0, [other]) is free
