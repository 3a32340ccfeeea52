"""Car following, stopping and path following."""

import math

import numpy as np
import pytest

from plant_bench.agent import Control, Plan, RouteAhead
from plant_bench.agents.idm import idm, stop_within
from plant_bench.controller import follow_plan, follow_route
from plant_bench.sim.ego import advance
from plant_bench.world.scene import TICK, EgoState


def ahead(points: np.ndarray, ego: EgoState) -> RouteAhead:
    index = int(np.argmin(np.hypot(points[:, 0] - ego.x, points[:, 1] - ego.y)))
    part = points[index : index + 101]
    delta = np.gradient(part, axis=0)
    yaw = np.unwrap(np.arctan2(delta[:, 1], delta[:, 0]))
    return RouteAhead(float(index), 0.0, 0.0, part, yaw, np.full(len(part), 10.0))


def test_controller_reaches_and_holds_the_target_speed() -> None:
    speed = 0.0
    for _ in range(600):
        speed += TICK * idm(speed, 10.0)
    assert speed == pytest.approx(10.0, abs=0.05)


def test_controller_stops_behind_a_stationary_leader() -> None:
    place, speed, leader = 0.0, 13.9, 80.0
    for _ in range(800):
        speed = max(0.0, speed + TICK * idm(speed, 13.9, leader - place, 0.0))
        place += TICK * speed
    assert 1.5 < leader - place < 4.0
    assert speed < 0.05


@pytest.mark.parametrize("speed", [3.0, 8.0, 13.9])
def test_controller_stops_shortly_before_the_line(speed: float) -> None:
    place, line = 0.0, speed * speed / 4.0 + 5.0
    for _ in range(800):
        speed = max(0.0, speed + TICK * stop_within(speed, line - place))
        place += TICK * speed
    assert 0.0 < line - place < 2.0


@pytest.mark.parametrize(("radius", "speed"), [(7.0, 4.0), (15.0, 6.0), (60.0, 12.0)])
def test_controller_follows_a_curve_within_a_third_of_a_metre(radius: float, speed: float) -> None:
    turn = np.arange(0.0, math.pi / 2, 1.0 / radius)
    curve = np.stack((radius * np.sin(turn), radius * (1.0 - np.cos(turn))), axis=1)
    straight = np.stack((np.arange(-40.0, 0.0), np.zeros(40)), axis=1)
    out = curve[-1] + np.stack((np.zeros(60), np.arange(1.0, 61.0)), axis=1)
    points = np.concatenate((straight, curve, out))
    ego = EgoState(-40.0, 0.0, 0.0, speed)
    worst = 0.0
    for _ in range(round((60.0 + radius) / speed / TICK)):
        ego = advance(ego, Control(0.0, follow_route(ego, ahead(points, ego))))
        worst = max(worst, float(np.min(np.hypot(points[:, 0] - ego.x, points[:, 1] - ego.y))))
    assert worst < 0.33 + 0.5  # the points are a metre apart: half of that is no error


def test_stationary_plan_brakes() -> None:
    control = follow_plan(Plan(np.zeros((4, 2))), EgoState(0.0, 0.0, 0.0, 5.0))
    assert control.acceleration < -1.0


def test_plan_determines_acceleration_and_steering() -> None:
    plan = Plan(np.array([[4.0, 0.5], [8.0, 2.0], [12.0, 4.5], [16.0, 8.0]]))
    control = follow_plan(plan, EgoState(0.0, 0.0, 0.0, 5.0))
    assert control.acceleration > 1.0
    assert control.steering > 0.05
