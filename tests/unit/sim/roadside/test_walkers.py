"""Pedestrians: their paths, when they step out, and their privileged facts."""

import random
from collections.abc import Sequence

import numpy as np
import pytest

from plant_bench.sim.roadside.footways import Crossing, Footways, Heading, Turn
from plant_bench.sim.roadside.pedestrians import ENTRY_RADIUS, EXIT_RADIUS, Walkers
from plant_bench.sim.roadside.road_crossing import MovingVehicle
from plant_bench.sim.roadside.walking_paths import SAMPLE, random_walk
from plant_bench.world.actor_ids import PEDESTRIANS
from plant_bench.world.scene import TICK, Actors, EgoState
from tests.builders import make_ego

OVER = Crossing("c", ((40.0, 1.0, 0.0), (40.0, 8.0, 0.0)), 4.0)


def two_sidewalks() -> Footways:
    """Two sidewalks along a road of 7 m, with a crossing at their eastern ends."""
    south = np.array([(-40.0, 0.0, 0.0), (40.0, 0.0, 0.0)])
    sidewalks = {"south": south, "north": south[::-1] + (0.0, 9.0, 0.0)}
    east, west = Heading("south", True), Heading("north", True)
    turns = {
        east: (Turn(west, OVER, False, 0.6),),
        Heading("north", False): (Turn(Heading("south", False), OVER, True, 0.6),),
        west: (Turn(east),),
        Heading("south", False): (Turn(Heading("north", False)),),
    }
    return Footways(sidewalks, turns)


class Rule:
    """A stub for `CrossingRules`."""

    def __init__(self, allowed: bool) -> None:
        self.answer = allowed

    def allowed(
        self,
        crossing: Crossing,
        duration: float,
        ego: EgoState,
        progress: float,
        others: Sequence[MovingVehicle],
    ) -> bool:
        return self.answer


class Shown:
    """A stub for the SUMO proxies."""

    def __init__(self) -> None:
        self.now: set[int] = set()

    def show(self, tick: int, walker: int, pose: tuple[float, float, float], speed: float) -> None:
        self.now.add(walker)

    def withdraw(self, walker: int) -> None:
        self.now.discard(walker)


@pytest.fixture
def far_ego() -> EgoState:
    return make_ego(y=60.0)


def walkers(*, allowed: bool, shown: Shown | None = None, density: float = 100.0) -> Walkers:
    found = Walkers(two_sidewalks(), Rule(allowed), shown or Shown(), density, 7)
    found.manage(0.0, 0.0, inner=0.0, most=20)
    return found


def run(crowd: Walkers, ego: EgoState, seconds: float) -> list[np.ndarray]:
    poses = []
    for tick in range(round(seconds / TICK)):
        crowd.step(tick, ego, 0.0, Actors.none())
        poses.append(crowd.poses.copy())
    return poses


def test_walk_is_continuous_and_marks_its_crossings() -> None:
    walk = random_walk(two_sidewalks(), Heading("south", True), 50.0, random.Random(1))
    steps = np.hypot(*np.diff(walk.samples[:, :2], axis=0).T)
    assert steps.max() < SAMPLE + 1e-6
    kerb = walk.kerbs[0]
    waiting, entering, left = (
        walk.samples[round(at / SAMPLE), 1] for at in (kerb.wait, kerb.enter, kerb.leave)
    )
    assert waiting < 0.9
    assert entering == pytest.approx(0.7, abs=0.5)
    assert left > 7.8


def test_pedestrians_without_permission_do_not_cross(far_ego: EgoState) -> None:
    crowd = walkers(allowed=False)
    poses = np.concatenate(run(crowd, far_ego, 90.0))
    assert ((poses[:, 1] < 0.8) | (poses[:, 1] > 8.2) | (poses[:, 0] < 0.0)).all()


def test_pedestrians_with_permission_cross_and_are_shown_meanwhile(far_ego: EgoState) -> None:
    shown = Shown()
    crowd = walkers(allowed=True, shown=shown)
    seen = 0
    for tick in range(1800):
        crowd.step(tick, far_ego, 0.0, Actors.none())
        east = crowd.poses[:, 0] > 20.0
        on_road = (crowd.poses[:, 1] > 1.0) & (crowd.poses[:, 1] < 8.0) & east
        assert set(crowd.ids[on_road].tolist()) <= shown.now
        seen += len(shown.now)
        assert len(shown.now) < len(crowd.ids)
    assert seen > 100


def test_pedestrians_do_not_walk_into_a_stationary_ego() -> None:
    ego = make_ego(x=40.0, y=4.0)  # across the way over the road
    crowd = walkers(allowed=True)
    poses = np.concatenate(run(crowd, ego, 30.0))
    inside = (np.abs(poses[:, 0] - 40.0) < 2.45) & (np.abs(poses[:, 1] - 4.0) < 1.065 + 0.2)
    assert not inside.any()
    assert (np.hypot(poses[:, 0] - 40.0, poses[:, 1] - 4.0) < 3.0).any()  # they did come


def test_pedestrians_are_added_and_removed_far_from_the_ego() -> None:
    crowd = walkers(allowed=True)
    before = len(crowd.ids)
    assert before == pytest.approx(100.0 * 0.16, abs=2)
    crowd.manage(0.0, EXIT_RADIUS - 20.0)
    assert len(crowd.ids) == before
    crowd.manage(-EXIT_RADIUS - 60.0, 0.0)
    assert len(crowd.ids) == 0
    x = ENTRY_RADIUS + 10.0
    crowd.manage(x, 0.0)
    away = np.hypot(crowd.poses[:, 0] - x, crowd.poses[:, 1])
    assert len(away)
    assert away.min() > ENTRY_RADIUS - 6.0


def test_pedestrian_facts_hold_path_stop_and_waiting_time(far_ego: EgoState) -> None:
    crowd = walkers(allowed=False)
    run(crowd, far_ego, 90.0)
    rows = crowd.seen(0.0, 0.0, 0.0, 200.0, 4.0)
    actors, facts = crowd.actors(rows), crowd.facts(1800, rows)
    assert (np.diff(actors.ids) > 0).all()
    assert actors.ids[0] in PEDESTRIANS
    starts = np.hypot(*(facts.paths[:, 0, :2] - actors.poses[:, :2]).T)
    assert starts.max() < 0.3
    waiting = actors.speeds == 0.0
    assert waiting.any()
    assert (facts.stop_distances[waiting] < 0.1).all()
    assert (facts.stopped_for[waiting] > 0.0).all()
    assert ((facts.desired_speeds >= 1.2) & (facts.desired_speeds <= 1.5)).all()


def test_same_seed_gives_the_same_walks(far_ego: EgoState) -> None:
    one, other = (run(walkers(allowed=True), far_ego, 5.0)[-1] for _ in range(2))
    assert np.array_equal(one, other)


def test_zero_density_has_no_pedestrians() -> None:
    assert len(walkers(allowed=True, density=0.0).ids) == 0
