"""Rankings without a learned planner, and masking for planners that do not rank."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant_bench.agent import Control, Input, Observation, Plan, Privileged, RouteAhead
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.ranking.expert_filtered import FilteredExpert
from plant_bench.agents.ranking.masking import Masking, expected_waypoints
from plant_bench.agents.ranking.rankers import Oracle, Random
from plant_bench.errors import AgentError, InputError
from plant_bench.world.route import LaneSpan, Route
from plant_bench.world.scene import ActorKind, Actors, EgoState

LEADER, ASIDE, WALKER = 5, 6, 500_001


def straight_route() -> Route:
    return Route(
        id="straight",
        town="none",
        points=np.stack((np.arange(201.0), np.zeros(201)), axis=1),
        elevations=np.zeros(201),
        speed_limits=np.full(201, 10.0),
        edges=("e",),
        lanes=(LaneSpan("e_0", 0.0, 200.0),),
        passages=(),
        lane_changes=(),
        manoeuvres={},
    )


def scene(*places: tuple[int, float, float]) -> Observation:
    """Return an observation at 8 m/s among stationary actors of the given id, x and y."""
    count = len(places)
    poses = np.array([(x, y, 0.0) for _, x, y in places], np.float32).reshape(-1, 3)
    ids = np.array([name for name, _, _ in places], np.int64)
    kinds = np.where(ids >= 500_000, ActorKind.PEDESTRIAN, ActorKind.CAR).astype(np.uint8)
    extents = np.tile(np.array([4.5, 1.8], np.float32), (count, 1))
    paths = np.repeat(poses[:, None].astype(float), 121, axis=1)
    paths[:, :, 0] += np.arange(121.0)
    zeros = np.zeros(count)
    facts = Privileged(paths, zeros, zeros, np.full(count, math.inf), zeros)
    points = np.stack((np.arange(101.0), np.zeros(101)), axis=1)
    ahead = RouteAhead(0.0, 0.0, 0.0, points, np.zeros(101), np.full(101, 10.0))
    actors = Actors(ids, poses, np.zeros(count, np.float32), extents, kinds)
    return Observation(0.0, EgoState(0.0, 0.0, 0.0, 8.0), 10.0, actors, ahead, None, facts)


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
