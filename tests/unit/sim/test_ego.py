"""The ego's vehicle model."""

import math

import pytest

from plant_bench.agent import Control
from plant_bench.sim.ego import (
    ACCELERATION_LIMIT,
    BRAKING_LIMIT,
    REAR_AXLE,
    STEERING_LIMIT,
    WHEELBASE,
    advance,
)
from plant_bench.world.scene import TICK, EgoState
from tests.builders import make_ego


def drive(ego: EgoState, control: Control, seconds: float) -> EgoState:
    for _ in range(round(seconds / TICK)):
        ego = advance(ego, control)
    return ego


def test_ego_driving_straight_covers_speed_times_time() -> None:
    ego = drive(make_ego(20.0), Control(0.0, 0.0), 2.0)
    assert (ego.x, ego.y) == pytest.approx((40.0, 0.0))


def test_constant_steering_gives_the_bicycle_model_radius() -> None:
    steering = 0.3
    radius = WHEELBASE / math.tan(steering)
    start = make_ego(5.0, x=REAR_AXLE, steering=steering)
    around = 2.0 * math.pi * radius / (5.0 * TICK)
    ego = start
    for _ in range(round(around)):
        ego = advance(ego, Control(0.0, steering))
    rear = ego.x - REAR_AXLE * math.cos(ego.yaw), ego.y - REAR_AXLE * math.sin(ego.yaw)
    assert math.hypot(rear[0], rear[1] - radius) == pytest.approx(radius, abs=1e-3)
    assert math.hypot(*rear) < 5.0 * TICK


def test_full_braking_stops_without_reversing() -> None:
    ego = drive(make_ego(16.0), Control(-100.0, 0.0), 4.0)
    assert ego.speed == 0.0
    ideal = 16.0**2 / (2.0 * BRAKING_LIMIT)
    assert ideal < ego.x < ideal + 16.0 * 0.25  # the brakes take 0.2 s to build up
    assert drive(ego, Control(-100.0, 0.0), 1.0).x == ego.x


def test_actuators_have_limits_and_delay() -> None:
    ego = make_ego(5.0)
    assert advance(ego, Control(0.0, 9.0)).steering == pytest.approx(1.0 * TICK)
    ego = drive(ego, Control(99.0, 9.0), 2.0)
    assert ego.steering == pytest.approx(STEERING_LIMIT)
    assert ego.acceleration == pytest.approx(ACCELERATION_LIMIT)


def test_stationary_ego_does_not_turn() -> None:
    ego = drive(make_ego(x=1.0, y=2.0, yaw=0.5), Control(0.0, 0.6), 1.0)
    assert ego.pose == pytest.approx((1.0, 2.0, 0.5))
