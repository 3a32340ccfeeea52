"""Querying a planner: when it decides, its ranks, its memory and its errors."""

from typing import Any

import numpy as np
import pytest

from plant_bench.agent import Cause, Control, Input, Plan, Reason
from plant_bench.errors import AgentError
from plant_bench.runner.decisions import Decision, PlannerSession, same_action
from plant_bench.runner.review.actor_ranking import rank_actors
from plant_bench.world.scene import ActorKind, Scene
from tests.builders import make_actors, make_ego, make_scene

NEAR, FAR, WALKER = 3, 9, 500_000


def scene(tick: int) -> Scene:
    actors = make_actors(
        [(6.0, 0.0), (30.0, 0.0), (7.0, 5.0)],
        extents=(2.0, 2.0),
        kinds=(ActorKind.CAR, ActorKind.CAR, ActorKind.PEDESTRIAN),
        ids=(NEAR, FAR, WALKER),
    )
    return make_scene(tick, ego=make_ego(5.0), actors=actors)


def started(agent: Any, route: Any) -> PlannerSession:
    session = PlannerSession(agent, route, 0)
    session.start()
    return session


def asked(session: PlannerSession, tick: int = 0) -> Decision:
    here = scene(tick)
    return session.decide(here, session.observe(here, 0.0, 0.0, None))


def ranking(session: PlannerSession) -> tuple[int, ...] | None:
    return rank_actors(session.agent, session.observe(scene(0), 0.0, 0.0, None))


class Counts:
    """Brakes harder the more actors are in sight; counts its calls."""

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
    """Ranks the farthest actor first, and changes its call counter."""

    def rank(self, observation: Any) -> np.ndarray:
        self.asked = -100
        return observation.actors.poses[:, 0].astype(float)


def test_a_planner_decides_at_its_own_interval(route):
    session = started(agent := Counts(), route("a"))

    told = [asked(session, tick) for tick in range(10) if session.due(tick)]

    assert [decision.tick for decision in told] == [0, 4, 8]
    assert told[0].control == Control(-10.0 / 6.0, 0.0)
    assert told[0].reason == Reason(Cause.LEADER, NEAR)
    assert (agent.resets, agent.asked) == (1, 3)
    assert told[0].ranking is None


def test_ranking_is_computed_by_a_copy_of_the_planner(route):
    session = started(agent := Ranks(), route("a"))

    ranks = ranking(session)
    asked(session)

    assert ranks == (FAR, WALKER, NEAR)
    assert agent.asked == 1


def test_planner_without_ranks_is_ranked_by_masking(route):
    session = started(agent := Counts(), route("a"))

    ranks = ranking(session)
    asked(session)

    assert ranks == (NEAR,)
    assert agent.asked == 1


def test_planner_that_cannot_be_copied_responds_without_ranking(route):
    agent = Counts()
    agent.held = (item for item in ())  # pyright: ignore[reportAttributeAccessIssue]
    session = started(agent, route("a"))

    assert ranking(session) is None
    assert asked(session).control.acceleration < 0.0


@pytest.mark.parametrize(
    ("method", "words"),
    [("act", "act raised ZeroDivisionError"), ("explain", "explain raised ZeroDivisionError")],
)
def test_failing_planner_raises_agent_error(route, method, words):
    agent = Counts()
    setattr(agent, method, lambda *_: 1 / 0)

    session = PlannerSession(agent, route("a"), 0, "the other's ")
    session.start()
    with pytest.raises(AgentError, match=f"the other's {words}"):
        asked(session)


def test_a_planner_with_an_unknown_input_is_refused(route):
    agent = Counts()
    agent.inputs = frozenset({"x-ray"})  # pyright: ignore[reportAttributeAccessIssue]

    with pytest.raises(AgentError, match="unknown inputs x-ray: choose from objects"):
        PlannerSession(agent, route("a"), 0)


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
def test_decision_equals_the_recorded_one_up_to_rounding(recorded: Any, same: bool):
    decision = Decision(0, Control(1.0, 0.5), Control(1.0, 0.5), None)

    assert same_action(decision, recorded) is same


def test_plans_are_compared_by_their_waypoints():
    one, other = np.ones((4, 2)), np.ones((4, 2))
    other[3, 1] += 0.01
    decision = Decision(0, Plan(one), Control(0.0, 0.0), None)

    assert same_action(decision, Plan(one + 1e-6))
    assert not same_action(decision, Plan(other))
