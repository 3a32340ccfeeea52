"""The rule-based safety layer brakes where it must, and does nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import Cause, Control, Input, Observation, Plan
from plant_bench.agents.guarded import EMERGENCY, Guarded
from plant_bench.world.route import Route
from tests.builders import (
    make_actors,
    make_ego,
    make_observation,
    straight_route,
    straight_route_ahead,
)

SPEED = 10.0
GO_ON = Plan(np.stack((np.arange(1, 5) * 0.5 * SPEED, np.zeros(4)), axis=1))


class Fixed:
    """Always returns the same action."""

    inputs = frozenset({Input.ROUTE})
    interval = 3

    def __init__(self, action: Plan | Control) -> None:
        self.action = action
        self.seen: list[Observation] = []

    def reset(self, route: Route | None) -> None:
        self.route = route

    def act(self, observation: Observation) -> Plan | Control:
        self.seen.append(observation)
        return self.action


def observe(*ahead: float, speed: float = SPEED) -> Observation:
    """A straight road with a stationary car at each of some distances ahead."""
    return make_observation(
        ego=make_ego(speed),
        speed_limit=12.0,
        actors=make_actors([(x, 0.0) for x in ahead]),
        route=straight_route_ahead(speed_limits=12.0),
    )


@pytest.fixture
def route() -> Route:
    """A straight road without junctions."""
    return straight_route(100, speed_limit=12.0)


def guarded(action: Plan | Control, route: Route) -> Guarded:
    agent = Guarded(Fixed(action))
    agent.reset(route)
    return agent


def test_planner_decides_on_a_free_road(route: Route) -> None:
    agent = guarded(GO_ON, route)
    assert agent.act(observe()) is GO_ON
    assert agent.explain() is None
    assert agent.interval == 3


def test_safety_layer_brakes_for_an_actor_the_planner_ignores(route: Route) -> None:
    agent = guarded(Control(1.0, 0.05), route)
    action = agent.act(observe(18.0))
    assert isinstance(action, Control)
    assert action.acceleration < EMERGENCY
    assert action.steering == 0.05  # it never steers
    reason = agent.explain()
    assert reason is not None
    assert (reason.cause, reason.actor) == (Cause.LEADER, 0)


def test_safety_layer_leaves_gentle_braking_to_the_planner(route: Route) -> None:
    agent = guarded(GO_ON, route)
    assert agent.act(observe(45.0)) is GO_ON


def test_harder_braking_of_the_planner_is_kept(route: Route) -> None:
    stop = Control(-8.0, 0.0)
    assert guarded(stop, route).act(observe(18.0)) is stop


def test_safety_layer_does_not_act_on_a_stationary_ego(route: Route) -> None:
    stay = Control(0.0, 0.0)
    assert guarded(stay, route).act(observe(4.0, speed=0.0)) is stay


def test_guarded_planner_receives_only_its_declared_inputs(route: Route) -> None:
    planner = Fixed(GO_ON)
    agent = Guarded(planner)
    agent.reset(route)
    agent.act(observe(18.0))
    assert planner.seen[0].actors is None
    assert planner.route is route


def test_safety_layer_predicts_a_car_that_pulls_out(route: Route) -> None:
    """A car that has just started to cross is predicted by its acceleration, not by its speed."""
    agent = guarded(GO_ON, route)
    before, now = observe(20.0), replace(observe(20.0), time=0.5)
    for observation, speed in ((before, 0.2), (now, 1.7)):
        assert observation.actors is not None
        observation.actors.poses[0] = 20.0, -6.5, 0.5 * np.pi
        observation.actors.speeds[0] = speed
    agent.act(before)
    action = agent.act(now)
    assert isinstance(action, Control)
    assert action.acceleration < EMERGENCY


def crossing(x: float, y: float, speed: float, ego_speed: float) -> Observation:
    """A car that crosses the road from the right."""
    seen = observe(x, speed=ego_speed)
    assert seen.actors is not None
    seen.actors.poses[0] = x, y, 0.5 * np.pi
    seen.actors.speeds[0] = speed
    return seen


def test_safety_layer_prevents_acceleration_into_a_conflict(route: Route) -> None:
    scene = crossing(20.0, -16.0, 8.0, 6.0)
    action = guarded(Control(2.0, 0.0), route).act(scene)
    assert isinstance(action, Control)
    assert action.acceleration < 1.0
    keep = Control(0.0, 0.0)  # it passes behind the car at its current speed
    assert guarded(keep, route).act(scene) is keep


def test_safety_layer_checks_less_often_on_a_free_road(route: Route) -> None:
    """This halves the cost on a free road; a new actor is seen at most 0.2 s later."""
    agent = guarded(Control(0.0, 0.0), route)
    agent.act(observe())
    sudden = [replace(observe(12.0), time=time) for time in (0.1, 0.2)]
    first, second = (agent.act(scene) for scene in sudden)
    assert isinstance(first, Control)
    assert isinstance(second, Control)
    assert first.acceleration == 0.0
    assert second.acceleration < EMERGENCY
