"""A planner that is shown only the highest-ranked actors."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import (
    Control,
    Input,
    NextLight,
    Observation,
    Plan,
    Privileged,
    Reason,
)
from plant_bench.agents.ranking.expert_nearest import expert_nearest
from plant_bench.agents.ranking.filtered_planner import Filtered, highest
from plant_bench.agents.ranking.rankers import Nearest
from plant_bench.errors import AgentError
from plant_bench.world.route import Route
from plant_bench.world.scene import ActorKind, Light
from tests.builders import make_actors, make_ego, make_observation

PLACES = ((30.0, 0.0), (5.0, 5.0), (-2.0, 0.0))


class Listener:
    """Records its observations."""

    inputs = frozenset({Input.OBJECTS, Input.LIGHT, Input.PRIVILEGED})
    interval = 3

    def __init__(self) -> None:
        self.seen: list[Observation] = []

    def reset(self, route: Route | None) -> None:
        assert route is None

    def act(self, observation: Observation) -> Plan | Control:
        self.seen.append(observation)
        return Control(0.5, 0.1)


class Judge(Listener):
    """A planner that ranks: the higher the id, the more relevant."""

    inputs = frozenset({Input.OBJECTS, Input.ROUTE})

    def reset(self, route: Route | None) -> None:
        self.seen.clear()

    def rank(self, observation: Observation) -> np.ndarray:
        self.seen.append(observation)
        assert observation.actors is not None
        return observation.actors.ids.astype(float)


def observe() -> Observation:
    each = np.arange(float(len(PLACES)))
    return make_observation(
        ego=make_ego(1.0),
        actors=make_actors(PLACES, extents=(1.0, 1.0), ids=(7, 8, 9)),
        light=NextLight(Light.RED, 9.0),
        privileged=Privileged(np.zeros((len(PLACES), 121, 3)), each, each, each, each),
    )


def test_only_the_nearest_actor_is_shown_with_its_facts() -> None:
    listener = Listener()
    assert Filtered(listener, Nearest()).act(observe()) == Control(0.5, 0.1)
    (seen,) = listener.seen
    assert seen.actors is not None
    assert seen.privileged is not None
    assert seen.actors.ids.tolist() == [9]
    assert seen.privileged.accelerations.tolist() == [2.0]
    assert (seen.ego, seen.light) == (observe().ego, observe().light)


def test_only_the_first_ranked_actors_are_shown_in_order() -> None:
    listener = Listener()
    Filtered(listener, Judge(), most=2).act(observe())
    assert listener.seen[0].actors is not None
    assert listener.seen[0].actors.ids.tolist() == [8, 9]


@pytest.mark.parametrize("most", [0, 3, 10])
def test_filter_can_show_no_actor_or_all(most: int) -> None:
    listener = Listener()
    Filtered(listener, Nearest(), most).act(observe())
    assert listener.seen[0].actors is not None
    assert len(listener.seen[0].actors) == min(most, 3)


def test_planner_and_ranker_receive_their_own_inputs() -> None:
    listener, judge = Listener(), Judge()
    filtered = Filtered(listener, judge)
    assert filtered.inputs == listener.inputs | judge.inputs
    assert filtered.interval == 3
    filtered.reset(None)
    filtered.act(observe())
    assert judge.seen[0].privileged is None
    assert judge.seen[0].light is None


def test_ties_are_broken_by_the_lower_id() -> None:
    ids = np.array([4, 2, 3])
    assert highest(np.array([1.0, 1.0, 1.0]), ids, 1).tolist() == [1]
    assert highest(np.array([1.0, 0.0, 1.0]), ids, 1).tolist() == [2]
    assert highest(np.array([1.0, 1.0, 2.0]), ids, 2).tolist() == [1, 2]


@pytest.mark.parametrize("ranks", [np.zeros(2), np.array([1.0, np.nan, 0.0])])
def test_invalid_ranks_raise_an_error(ranks: np.ndarray) -> None:
    with pytest.raises(AgentError, match="finite values, got shape"):
        highest(ranks, np.arange(3), 1)


def test_a_planner_without_objects_cannot_be_filtered() -> None:
    class Blind(Listener):
        inputs = frozenset({Input.ROUTE})

    with pytest.raises(AgentError, match="expected a planner with the input 'objects'"):
        Filtered(Blind(), Nearest())


def test_planner_without_explain_gives_no_reason() -> None:
    assert Filtered(Listener(), Nearest()).explain() is None
    assert isinstance(expert_nearest().explain(), Reason)


def test_vehicles_only_filter_keeps_pedestrians() -> None:
    listener = Listener()
    seen = observe()
    assert seen.actors is not None
    kinds = np.array([ActorKind.CAR, ActorKind.PEDESTRIAN, ActorKind.BICYCLE], np.uint8)
    walking = replace(seen, actors=replace(seen.actors, kinds=kinds))
    for most, shown in ((1, [8, 9]), (0, [8]), (5, [7, 8, 9])):
        Filtered(listener, Nearest(), most, vehicles_only=True).act(walking)
        actors = listener.seen[-1].actors
        assert actors is not None
        assert actors.ids.tolist() == shown
