"""Forecasts from half a second of observed motion."""

import math

import numpy as np
import pytest

from plant_bench.agent import Observation
from plant_bench.agents.careful.forecast import TIMES, Forecast
from plant_bench.agents.careful.motion_forecast import HELD, MotionForecast
from plant_bench.world.scene import ActorKind
from tests.builders import make_actors, make_ego, make_observation

CAR = int(ActorKind.CAR)


def seen(time: float, speed: float, yaw: float = 0.0, kind: int = CAR) -> Observation:
    """One actor at the origin."""
    actors = make_actors([(0.0, 0.0, yaw)], speeds=speed, extents=(4.0, 2.0), kinds=kind, ids=[7])
    return make_observation(time=time, ego=make_ego(y=50.0), actors=actors)


def forecast_after(*observations: Observation) -> Forecast:
    """Return the forecast after the given observations."""
    forecast = MotionForecast()
    for observation in observations:
        forecast.update(observation)
    return forecast(observations[-1], np.array([0]))


def test_newly_seen_actor_is_forecast_straight_ahead() -> None:
    found = forecast_after(seen(0.0, 5.0))
    assert found.poses[0, :, 0] == pytest.approx(5.0 * TIMES)
    assert found.lengths[0] == pytest.approx(np.full(len(TIMES), 4.0))


def test_accelerating_actor_is_forecast_farther() -> None:
    found = forecast_after(seen(0.0, 4.0), seen(0.5, 5.0))
    front = found.poses[0, :, 0] + 0.5 * found.lengths[0]
    rear = found.poses[0, :, 0] - 0.5 * found.lengths[0]
    at = int(np.searchsorted(TIMES, HELD))
    assert front[at] == pytest.approx(2.0 + 5.0 * HELD + 0.5 * 2.0 * HELD**2)
    assert rear[at] == pytest.approx(-2.0 + 5.0 * HELD)  # or it goes on as it does


def test_turning_actor_is_forecast_to_keep_turning() -> None:
    found = forecast_after(seen(0.0, 5.0), seen(0.5, 5.0, yaw=0.25))
    assert found.poses[0, 4, 2] == pytest.approx(0.25 + 0.5, abs=1e-3)
    assert found.poses[0, 4, 1] > 5.0 * math.sin(0.25)


def test_pedestrians_are_forecast_straight_ahead() -> None:
    kind = int(ActorKind.PEDESTRIAN)
    found = forecast_after(seen(0.0, 0.5, kind=kind), seen(0.5, 1.5, yaw=1.0, kind=kind))
    assert found.poses[0, :, 2] == pytest.approx(np.full(len(TIMES), 1.0))
    assert found.lengths[0] == pytest.approx(np.full(len(TIMES), 4.0))


def test_reset_clears_the_observed_motion() -> None:
    forecast = MotionForecast()
    forecast.update(seen(0.0, 0.0))
    forecast.reset()
    forecast.update(seen(0.5, 5.0))
    found = forecast(seen(0.5, 5.0), np.array([0]))
    assert found.lengths[0] == pytest.approx(np.full(len(TIMES), 4.0))
