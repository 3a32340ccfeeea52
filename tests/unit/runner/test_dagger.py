"""Driving by another planner and takeovers by the expert, without a simulator."""

from typing import Any

import numpy as np
import pytest

from plant_bench.agent import Control, Input, Plan
from plant_bench.controller import follow_plan
from plant_bench.errors import AgentError, InputError
from plant_bench.runner.collect import dagger as takeover
from plant_bench.runner.collect.dagger import PATIENCE, TAKEOVER, DaggerOverride, check_driver
from plant_bench.world.scene import TICK
from tests.builders import make_ego, make_scene

OWN = Control(-1.0, 0.25)  # what the other planner answers
GO, STAY = Control(1.0, 0.0), Control(-0.5, 0.0)  # what the expert answers


class Driver:
    inputs = frozenset({Input.OBJECTS})
    interval = 1

    def __init__(self, action: Any = OWN, fails_to_reset: bool = False) -> None:
        self.action, self.fails_to_reset = action, fails_to_reset
        self.seen, self.resets = [], []

    def reset(self, route):
        if self.fails_to_reset:
            raise KeyError("weights")
        self.resets.append(route)

    def act(self, observation):
        self.seen.append(observation)
        return self.action() if callable(self.action) else self.action


@pytest.fixture
def at_the_wheel(monkeypatch, route):
    def make(driver):
        monkeypatch.setattr(takeover, "load_agent", lambda _spec: driver)
        return DaggerOverride("other", route("town01-long-0"), 0)

    return make


def scene(tick, speed=0.0):
    return make_scene(tick, ego=make_ego(speed, x=5.0))


def executed(wheel, answers, speed=0.0, first=0):
    told = enumerate(answers, first)
    return [wheel.executed(scene(tick, speed), 5.0, 0.0, answer) for tick, answer in told]


def test_driver_option_executes_the_other_planner(at_the_wheel):
    driver = Driver()
    wheel = at_the_wheel(driver)
    assert driver.resets == []  # a reset that fails is to end the episode, not the command
    assert executed(wheel, [GO] * 200, speed=8.0) == [OWN] * 200
    assert driver.resets == [None]  # it did not ask for the route
    assert driver.seen[0].actors is not None
    assert driver.seen[0].route is None


def test_driver_decides_at_its_interval_and_its_plans_are_followed(at_the_wheel):
    plan = Plan(np.array([[2.0, 0.0], [4.0, 0.5], [6.0, 1.5], [8.0, 3.0]]))
    driver = Driver(plan)
    driver.interval, driver.inputs = 2, frozenset({Input.ROUTE})
    done = executed(at_the_wheel(driver), [GO] * 10, speed=4.0)
    assert [round(seen.time / TICK) for seen in driver.seen] == [0, 2, 4, 6, 8]
    assert done == [follow_plan(plan, scene(0, 4.0).ego)] * 10
    assert driver.resets[0] is not None
    assert driver.seen[0].route.progress == 5.0


def test_expert_takes_over_if_the_driver_stands_for_too_long(at_the_wheel):
    patience, relief = round(PATIENCE / TICK), round(TAKEOVER / TICK)
    wheel = at_the_wheel(Driver())
    done = executed(wheel, [GO] * (2 * (patience + relief)))
    once = [OWN] * patience + [GO] * relief
    assert done == once + once


def test_expert_does_not_take_over_if_it_would_stand_too(at_the_wheel):
    patience = round(PATIENCE / TICK)
    wheel = at_the_wheel(Driver())
    assert executed(wheel, [STAY] * 3 * patience) == [OWN] * 3 * patience
    mostly = ([GO] * (patience - 1) + [STAY]) * 3  # the wish ends in time, again and again
    assert executed(wheel, mostly, first=3 * patience) == [OWN] * len(mostly)


def raising(error):
    def act():
        raise error

    return act


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (raising(ZeroDivisionError("by nought")), "driver's act raised ZeroDivisionError: by nou"),
        (raising(SystemExit(3)), "driver's act raised SystemExit"),
        ("left", "expected a Plan or a Control, got a str"),
        (Control(float("nan"), 0.0), "expected finite numbers"),
    ],
)
def test_failing_driver_raises_agent_error(at_the_wheel, action, words):
    with pytest.raises(AgentError, match=words):
        executed(at_the_wheel(Driver(action)), [GO])


def test_driver_failing_in_reset_raises_agent_error(at_the_wheel):
    with pytest.raises(AgentError, match="driver's reset raised KeyError"):
        executed(at_the_wheel(Driver(fails_to_reset=True)), [GO])


@pytest.mark.parametrize(
    ("driver", "words"),
    [
        ("expert", "'expert' cannot drive in a DAgger collection: its inputs include privileged"),
        ("sumo", "its inputs include simulator"),
        ("plnt", "Did you mean 'plant'"),
    ],
)
def test_planner_that_cannot_drive_is_refused(driver, words):
    with pytest.raises(InputError, match=words):
        check_driver(driver)
    check_driver("idm")
