"""The criterion for whether a vehicle can still stop."""

import pytest

from plant_bench.world.driver_braking import stopping_distance
from tests.builders import make_ego


@pytest.mark.parametrize(("speed", "metres"), [(0.0, 0.0), (8.0, 12.0), (12.0, 24.0)])
def test_stopping_distance_has_0_5_s_reaction_and_4_m_s2(speed: float, metres: float) -> None:
    assert stopping_distance(make_ego(speed)) == pytest.approx(metres)


def test_stopping_distance_includes_acceleration_while_reacting() -> None:
    assert stopping_distance(make_ego(8.0, acceleration=2.0)) == pytest.approx(
        0.5 * 8.5 + 9.0**2 / 8.0
    )
    assert stopping_distance(make_ego(8.0, acceleration=2.0), limit=8.0) == pytest.approx(12.0)
    assert stopping_distance(make_ego(8.0, acceleration=2.0), limit=5.0) == pytest.approx(12.0)
    assert stopping_distance(make_ego(8.0, acceleration=-3.0)) == pytest.approx(12.0)
