"""The one criterion of who could still stop."""

import pytest

from plant_bench.world.driver_braking import stopping_distance
from tests.builders import make_ego


@pytest.mark.parametrize(("speed", "metres"), [(0.0, 0.0), (8.0, 12.0), (12.0, 24.0)])
def test_half_a_second_and_then_four_metres_a_second_squared(speed: float, metres: float) -> None:
    assert stopping_distance(make_ego(speed)) == pytest.approx(metres)


def test_who_speeds_up_does_so_while_reacting_but_not_beyond_the_limit() -> None:
    assert stopping_distance(make_ego(8.0, acceleration=2.0)) == pytest.approx(
        0.5 * 8.5 + 9.0**2 / 8.0
    )
    assert stopping_distance(make_ego(8.0, acceleration=2.0), limit=8.0) == pytest.approx(12.0)
    assert stopping_distance(make_ego(8.0, acceleration=2.0), limit=5.0) == pytest.approx(12.0)
    assert stopping_distance(make_ego(8.0, acceleration=-3.0)) == pytest.approx(12.0)
