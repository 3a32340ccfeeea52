"""Red lights: the ego's rear crosses the stop line at x = 150 m while the light is red."""

import pytest

from plant_bench.world.scene import Light

NEAR_REAR = 150.0 + 0.8 * 2.45  # where the ego's centre is when the rear begins to cross
FAR_REAR = 150.0 + 2.45 + 1.0  # ... and when it has crossed


def test_red_light_is_counted_once(stage):
    stage.drive(200.0, light=Light.RED)
    (infraction,) = stage.verdict().infractions
    assert infraction.kind == "red_light"
    assert NEAR_REAR <= infraction.progress < NEAR_REAR + 0.5


@pytest.mark.parametrize("light", [Light.GREEN, Light.YELLOW, Light.UNKNOWN])
def test_only_red_lights_count(stage, light):
    assert stage.drive(200.0, light=light).kinds() == []


def test_front_over_the_stop_line_is_not_counted(stage):
    stage.drive(NEAR_REAR - 0.01, light=Light.RED).stand(50, light=Light.RED)
    assert stage.kinds() == []


def test_rear_over_the_stop_line_is_counted(stage):
    assert stage.drive(NEAR_REAR + 0.01, light=Light.RED).kinds() == ["red_light"]


def test_light_turning_red_after_the_rear_crossed_is_not_counted(stage):
    stage.drive(FAR_REAR + 0.01).drive(200.0, light=Light.RED)
    assert stage.kinds() == []


def test_light_turning_red_before_the_rear_crossed_is_counted(stage):
    stage.drive(FAR_REAR - 0.01).drive(200.0, light=Light.RED)
    assert stage.kinds() == ["red_light"]


def test_standing_on_the_line_when_it_turns_red_is_not_counted(stage):
    stage.drive(NEAR_REAR + 0.5).stand(100, light=Light.RED)
    assert stage.kinds() == []
    assert stage.drive(153.0, light=Light.RED).kinds() == ["red_light"]


def test_red_light_is_counted_at_any_speed(stage):
    stage.drive(151.0, speed=70.0).drive(158.0, speed=140.0, light=Light.RED)
    assert stage.kinds() == ["red_light"]


@pytest.mark.parametrize(("y", "expected"), [(-4.9, 1), (-5.1, 0)])
def test_lights_of_a_parallel_street_are_ignored(stage, y, expected):
    stage.drive(140.0, y=y, light=Light.RED).drive(160.0, y=y, light=Light.RED)
    assert stage.kinds().count("red_light") == expected
