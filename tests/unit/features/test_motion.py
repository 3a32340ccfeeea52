"""Rates of change between two observations, and the memory of the first."""

import math

import numpy as np
import pytest

from plant_bench.features.motion import MotionTracker, rates_between
from plant_bench.world.scene import ActorKind, Actors


def cars(*rows: tuple[int, float, float]) -> Actors:
    """Return cars of the given ids, speeds and yaws."""
    count = len(rows)
    return Actors(
        np.array([row[0] for row in rows], np.int64),
        np.array([(0.0, 0.0, row[2]) for row in rows], np.float32).reshape(count, 3),
        np.array([row[1] for row in rows], np.float32),
        np.tile(np.array([[4.5, 1.8]], np.float32), (count, 1)),
        np.full(count, ActorKind.CAR, np.uint8),
    )


def test_motion_rates_match_actors_by_id_and_wrap_angles() -> None:
    before = cars((3, 5.0, 3.1), (7, 2.0, 0.0))
    now = cars((7, 3.0, 0.1), (9, 8.0, 1.0), (3, 5.0, -3.1))

    rates = rates_between(before, now, 0.5)

    assert rates.accelerations.tolist() == pytest.approx([2.0, 0.0, 0.0])
    wrapped = (2.0 * math.pi - 6.2) / 0.5
    assert rates.turns.tolist() == pytest.approx([0.2, 0.0, wrapped], abs=1e-5)


@pytest.mark.parametrize("pause", [0.1, 0.2])
def test_motion_rates_use_the_last_half_second(pause: float) -> None:
    tracks = MotionTracker()
    for place in range(30):
        time = place * pause
        rates = tracks.rates(time, cars((1, 3.0 * time, 0.0)))
        wanted = 0.0 if time < 0.44 else 3.0
        assert rates.accelerations[0] == pytest.approx(wanted, abs=1e-4), time


def test_motion_rates_are_repeatable_and_copies_independent() -> None:
    tracks = MotionTracker()
    tracks.rates(0.0, cars((1, 0.0, 0.0)))
    other = tracks.copied()
    other.rates(0.3, cars((1, 9.0, 0.0)))

    first = tracks.rates(0.5, cars((1, 1.0, 0.0)))
    again = tracks.rates(0.5, cars((1, 1.0, 0.0)))

    assert first.accelerations.tolist() == again.accelerations.tolist() == [2.0]
    tracks.reset()
    assert tracks.rates(0.6, cars((1, 5.0, 0.0))).accelerations.tolist() == [0.0]
