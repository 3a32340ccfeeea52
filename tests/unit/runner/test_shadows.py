"""Planners asked in the shadow of another: when they decide, what they rank, what they remember."""

from typing import Any

import numpy as np
import pytest

from plant_bench.agent import Cause, Control, Input, Plan, Reason
from plant_bench.errors import AgentError
from plant_bench.runner.decisions import Answer, Shadow, same_answer
from plant_bench.world.scene import ActorKind, Actors, EgoState, Scene

NEAR, FAR, WALKER = 3, 9, 500_000


def scene(tick: int) -> Scene:
    actors = Actors(
        np.array([NEAR, FAR, WALKER]),
        np.array([[6.0, 0.0, 0.0], [30.0, 0.0, 0.0], [7.0, 5.0, 0.0]], np.float32),
        np.zeros(3, np.float32),
        np.full((3, 2), 2.0, np.float32),
        np.array([ActorKind.CAR, ActorKind.CAR, ActorKind.PEDESTRIAN], np.uint8),
    )
    return Scene(tick, EgoState(0.0, 0.0, 0.0, 5.0), actors, np.zeros(0, np.uint8))


class Counts:
    """Brakes the harder the more are in sight; remembers how often it was asked."""

    inputs = frozenset({Input.OBJECTS})
    interval = 4

    def __init__(self) -> None:
        self.asked, self.resets = 0, 0

    def reset(self, route: Any) -> None:
        self.resets += 1

    def act(self, observation: Any) -> Control:
        self.asked += 1
        nearest = min((float(pose[0]) for pose in observation.actors.poses), default=99.0)
        return Control(-10.0 / nearest, 0.0)

    def explain(self) -> Reason:
        return Reason(Cause.LEADER, NEAR)


class Ranks(Counts):
    """Ranks the farthest first, and forgets how often it was asked."""

    def rank(self, observation: Any) -> np.ndarray:
        self.asked = -100
        return observation.actors.poses[:, 0].astype(float)


def test_a_shadow_decides_at_its_own_interval(route):
    shadow = Shadow(agent := Counts(), route("a"))

    asked = []
    for tick in range(10):
        if shadow.due(tick):
            asked.append(shadow.answer(scene(tick), 0.0, 0.0, None))

    assert [answer.tick for answer in asked] == [0, 4, 8]
    assert asked[0].control == Control(-10.0 / 6.0, 0.0)
    assert asked[0].reason == Reason(Cause.LEADER, NEAR)
    assert (agent.resets, agent.asked) == (1, 3)
    assert asked[0].ranking is None


def test_a_planners_own_ranking_is_asked_of_a_copy(route):
    shadow = Shadow(agent := Ranks(), route("a"))

    answer = shadow.answer(scene(0), 0.0, 0.0, None, ranking=True)

    assert answer.ranking == (FAR, WALKER, NEAR)
    assert agent.asked == 1
    assert shadow.ranks_itself


def test_who_cannot_rank_is_asked_by_masking_and_those_without_effect_are_left_out(route):
    shadow = Shadow(agent := Counts(), route("a"))

    answer = shadow.answer(scene(0), 0.0, 0.0, None, ranking=True)

    assert answer.ranking == (NEAR,)
    assert agent.asked == 1
    assert not shadow.ranks_itself


def test_who_cannot_be_copied_has_no_ranking_but_answers(route):
    agent = Counts()
    agent.held = (item for item in ())  # pyright: ignore[reportAttributeAccessIssue]

    answer = Shadow(agent, route("a")).answer(scene(0), 0.0, 0.0, None, ranking=True)

    assert answer.ranking is None
    assert answer.control.acceleration < 0.0


def test_a_planner_that_fails_is_an_agent_error(route):
    agent = Counts()
    agent.act = lambda observation: 1 / 0  # pyright: ignore[reportAttributeAccessIssue]

    with pytest.raises(AgentError, match="act raised ZeroDivisionError"):
        Shadow(agent, route("a")).answer(scene(0), 0.0, 0.0, None)


@pytest.mark.parametrize(
    ("recorded", "same"),
    [
        (Control(1.0, 0.5), True),
        (Control(1.0 + 1e-9, 0.5), True),
        (Control(1.01, 0.5), False),
        (Plan(np.zeros((4, 2))), False),
        (None, False),
    ],
)
def test_an_answer_is_the_recorded_one_but_for_rounding(recorded: Any, same: bool):
    answer = Answer(0, Control(1.0, 0.5), Control(1.0, 0.5), None)

    assert same_answer(answer, recorded) is same


def test_plans_are_compared_by_their_waypoints():
    one, other = np.ones((4, 2)), np.ones((4, 2))
    other[3, 1] += 0.01
    answer = Answer(0, Plan(one), Control(0.0, 0.0), None)

    assert same_answer(answer, Plan(one + 1e-6))
    assert not same_answer(answer, Plan(other))
