"""The criterion for whether a vehicle can still stop."""

import pytest

from plant_bench.world.driver_braking import stopping_distance
from plant_bench.world.scene import EgoState


def ego(speed: float, acceleration: float = 0.0) -> EgoState:
    return EgoState(0.0, 0.0, 0.0, speed, acceleration)


@pytest.mark.parametrize(("speed", "metres"), [(0.0, 0.0), (8.0, 12.0), (12.0, 24.0)])
def test_stopping_distance_has_0_5_s_reaction_and_4_m_s2(speed: float, metres: float) -> None:
    assert stopping_distance(ego(speed)) == pytest.approx(metres)


def test_stopping_distance_includes_acceleration_while_reacting() -> None:
    assert stopping_distance(ego(8.0, 2.0)) == pytest.approx(0.5 * 8.5 + 9.0**2 / 8.0)
    assert stopping_distance(ego(8.0, 2.0), limit=8.0) == pytest.approx(12.0)
    assert stopping_distance(ego(8.0, 2.0), limit=5.0) == pytest.approx(12.0)
    assert stopping_distance(ego(8.0, -3.0)) == pytest.approx(12.0)
