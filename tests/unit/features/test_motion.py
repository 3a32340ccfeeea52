"""Rates of change between two observations, and the memory of the first."""

import math

import pytest

from plant_bench.features.motion import MotionTracker, rates_between
from plant_bench.world.scene import Actors
from tests.builders import cars


def seen(*rows: tuple[int, float, float]) -> Actors:
    """Return cars at the origin, of the given ids, speeds and yaws."""
    return cars(
        *((0.0, 0.0, yaw, speed) for _, speed, yaw in rows), ids=[number for number, _, _ in rows]
    )


def test_motion_rates_match_actors_by_id_and_wrap_angles() -> None:
    before = seen((3, 5.0, 3.1), (7, 2.0, 0.0))
    now = seen((7, 3.0, 0.1), (9, 8.0, 1.0), (3, 5.0, -3.1))

    rates = rates_between(before, now, 0.5)

    assert rates.accelerations.tolist() == pytest.approx([2.0, 0.0, 0.0])
    wrapped = (2.0 * math.pi - 6.2) / 0.5
    assert rates.turns.tolist() == pytest.approx([0.2, 0.0, wrapped], abs=1e-5)


@pytest.mark.parametrize("pause", [0.1, 0.2])
def test_motion_rates_use_the_last_half_second(pause: float) -> None:
    tracks = MotionTracker()
    for place in range(30):
        time = place * pause
        rates = tracks.rates(time, seen((1, 3.0 * time, 0.0)))
        wanted = 0.0 if time < 0.44 else 3.0
        assert rates.accelerations[0] == pytest.approx(wanted, abs=1e-4), time


def test_motion_rates_are_repeatable_and_copies_independent() -> None:
    tracks = MotionTracker()
    tracks.rates(0.0, seen((1, 0.0, 0.0)))
    other = tracks.copied()
    other.rates(0.3, seen((1, 9.0, 0.0)))

    first = tracks.rates(0.5, seen((1, 1.0, 0.0)))
    again = tracks.rates(0.5, seen((1, 1.0, 0.0)))

    assert first.accelerations.tolist() == again.accelerations.tolist() == [2.0]
    tracks.reset()
    assert tracks.rates(0.6, seen((1, 5.0, 0.0))).accelerations.tolist() == [0.0]
