"""Rankings without a learned planner, and masking for planners that do not rank."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant_bench.agent import Control, Input, Observation, Plan
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.ranking.expert_filtered import FilteredExpert
from plant_bench.agents.ranking.masking import Masking, expected_waypoints
from plant_bench.agents.ranking.rankers import Oracle, Random
from plant_bench.errors import AgentError, InputError
from plant_bench.world.route import Route
from plant_bench.world.scene import ActorKind, EgoState
from tests.builders import (
    make_actors,
    make_ego,
    make_observation,
    straight_lane_facts,
    straight_route,
    straight_route_ahead,
)

LEADER, ASIDE, WALKER = 5, 6, 500_001


def scene(*places: tuple[int, float, float]) -> Observation:
    """At 8 m/s on a straight road among stationary actors: id, x and y of each."""
    ids = [number for number, _, _ in places]
    actors = make_actors(
        [(x, y) for _, x, y in places],
        kinds=[ActorKind.PEDESTRIAN if number >= 500_000 else ActorKind.CAR for number in ids],
        ids=ids,
    )
    return make_observation(
        ego=make_ego(8.0),
        actors=actors,
        route=straight_route_ahead(),
        privileged=straight_lane_facts(actors, desired_speeds=0.0),
    )


BUSY = scene((LEADER, 20.0, 0.0), (ASIDE, 2.0, 6.0), (WALKER, 12.0, -8.0))


class Brakes:
    """Brakes a little for each vehicle ahead on its own lane; counts how often it is asked."""

    inputs = frozenset({Input.OBJECTS})
    asked = 0

    def reset(self, route: Route | None) -> None:
        self.asked = 0

    def act(self, observation: Observation) -> Plan | Control:
        self.asked += 1
        assert observation.actors is not None
        ahead = np.abs(observation.actors.poses[:, 1]) < 1.0
        return Control(-1.0 * int(ahead.sum()) - 0.1 * self.asked, 0.0)


def test_oracle_ranks_the_actor_the_expert_brakes_for_first() -> None:
    oracle = Oracle()
    oracle.reset(straight_route())
    assert np.argsort(-oracle.rank(BUSY)).tolist() == [0, 1, 2]


def test_oracle_ranks_by_distance_if_the_expert_does_not_brake() -> None:
    oracle = Oracle()
    oracle.reset(straight_route())
    free = scene((LEADER, -30.0, 20.0), (ASIDE, 2.0, 25.0))
    assert np.argsort(-oracle.rank(free)).tolist() == [1, 0]


def test_random_ranking_depends_only_on_the_scene() -> None:
    first, again = Random().rank(BUSY), Random().rank(BUSY)
    np.testing.assert_array_equal(first, again)
    assert (first != Random().rank(replace(BUSY, time=0.1))).all()


def test_masking_measures_the_change_of_the_plan_in_metres() -> None:
    ranks = Masking(Brakes()).rank(BUSY)
    ego = BUSY.ego
    whole, free = (expected_waypoints(Control(pull, 0.0), ego) for pull in (-1.1, -0.1))
    assert ranks[0] == pytest.approx(np.abs(free - whole).sum())
    assert ranks[1:].tolist() == pytest.approx([-math.hypot(2, 6), -math.hypot(12, 8)])


def test_masking_does_not_change_the_memory_of_the_planner() -> None:
    planner = Brakes()
    ranker = Masking(planner)
    ranker.rank(BUSY)
    ranker.rank(BUSY)
    assert planner.asked == 2


def test_masking_refuses_a_planner_that_cannot_be_copied() -> None:
    class Locked(Brakes):
        def __deepcopy__(self, memo: object) -> "Locked":
            raise TypeError("cannot pickle")

    with pytest.raises(AgentError, match="Locked cannot be copied"):
        Masking(Locked()).rank(BUSY)


def test_constant_control_leads_along_an_arc() -> None:
    ego = EgoState(3.0, 4.0, 1.0, 10.0)
    straight = expected_waypoints(Control(0.0, 0.0), ego)
    assert straight == pytest.approx(np.array([(5.0 * n, 0.0) for n in range(1, 5)]))
    assert (expected_waypoints(Control(0.0, 0.1), ego)[:, 1] > 0.0).all()
    assert expected_waypoints(Control(-8.0, 0.0), ego)[-1, 0] == pytest.approx(6.0, abs=0.3)


@pytest.mark.parametrize(
    ("ranking", "brakes"), [("oracle", True), ("masking:expert", True), ("none", False)]
)
def test_filtered_expert_brakes_for_shown_actors(ranking: str, brakes: bool) -> None:
    agent = FilteredExpert(ranking)
    agent.reset(straight_route())
    action = agent.act(scene((LEADER, 14.0, 0.0), (ASIDE, 2.0, 6.0)))
    assert isinstance(action, Control)
    assert (action.acceleration < -2.0) is brakes


PLANNER = """
from plant_bench.agent import Control, Input

class Mine:
    inputs = frozenset({Input.OBJECTS})
    def reset(self, route): ...
    def act(self, observation): return Control(0.0, 0.0)
"""


@pytest.fixture
def planner(tmp_path: Path) -> Path:
    path = tmp_path / "ranked_planner.py"
    path.write_text(PLANNER)
    return path


def test_checksum_covers_the_ranker(planner: Path) -> None:
    spec = f"expert-filtered@masking:{planner}:Mine"
    before = agent_checksum(spec)
    planner.write_text(PLANNER + "CHANGED = 1\n")
    assert agent_checksum(spec) != before
    assert agent_checksum("expert-filtered") == agent_checksum("expert-filtered@oracle")


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("nearest", "There is no ranking 'nearest'"),
        ("distance:expert", "There is no ranking"),
        ("masking", "or masking:AGENT"),
        ("masking:exprt", "Did you mean 'expert'"),
        ("attention:expert", "'expert' has no `rank`"),
        ("masking:cruise", "has no input 'objects'"),
        ("masking:command:./my_planner", "cannot be ranked by masking"),
    ],
)
def test_unknown_ranker_raises_input_error(spec: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_agent(f"expert-filtered@{spec}")
