"""Pedestrians and parked cars in the towns: fair, continuous and repeatable."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from plant_bench.agent import Control, Input
from plant_bench.agents.loading.registry import load_agent
from plant_bench.geometry.box import overlap_one
from plant_bench.scoring.referee import Referee
from plant_bench.sensing.observe import Sensors
from plant_bench.sim.roadside.lane_distance import Roadway
from plant_bench.sim.simulation import Simulation
from plant_bench.sim.town_layout import places_of
from plant_bench.sim.traffic import SIGHT
from plant_bench.world.route import Scenario
from plant_bench.world.scene import EGO_EXTENT, TICK, ActorKind, Actors, Scene
from tests.builders import suite_route

pytestmark = pytest.mark.sumo


def on_foot(scene: Scene) -> Actors:
    return scene.actors.only(~scene.actors.in_traffic & ~scene.actors.parked)


def drive(scenario: Scenario, ticks: int, stand_at: float = np.inf) -> list[Scene]:
    """Drive as the expert does, and stand still from an arc length of the route on."""
    driver = load_agent("expert")
    driver.reset(scenario.route)
    with Simulation(scenario) as simulation:
        referee = Referee(simulation.town, scenario.route)
        scenes = [simulation.scene]
        control = Control(0.0, 0.0)
        for tick in range(ticks):
            referee.judge(simulation.scene)
            if referee.progress >= stand_at:
                control = Control(-8.0, 0.0)
            elif tick % 2 == 0:
                facts = simulation.privileged()
                progress, offset = referee.progress, referee.offset
                seen = Sensors(scenario.route, scenario.seed, frozenset(Input)).observe(
                    scenes[-1], progress, offset, facts
                )
                action = driver.act(seen)
                assert isinstance(action, Control)
                control = action
            scenes.append(simulation.step(control))
    return scenes


def test_pedestrians_move_at_their_speed_and_appear_out_of_sight() -> None:
    scenes = drive(Scenario(suite_route("town02-0"), 3), 1200)
    assert np.mean([len(on_foot(scene)) for scene in scenes]) > 2.0
    for before, after in pairwise(scenes):
        one, other = on_foot(before), on_foot(after)
        _, here, there = np.intersect1d(one.ids, other.ids, return_indices=True)
        moved = np.hypot(*(other.poses[there, :2] - one.poses[here, :2]).T)
        assert np.abs(moved - TICK * other.speeds[there]).max(initial=0.0) < 0.02
        for scene, some, rest in ((before, one, other), (after, other, one)):
            odd = some.poses[~np.isin(some.ids, rest.ids), :2] - (scene.ego.x, scene.ego.y)
            assert np.hypot(*odd.T).min(initial=SIGHT) > SIGHT - 2.0


def test_pedestrians_do_not_walk_into_an_ego_standing_on_a_crossing() -> None:
    # where people want to cross: without the rules some walk into it
    whole = suite_route("town02-3")
    at = whole.passages[0].entry + 3.0  # the crossing lies just behind the line
    scenes = drive(Scenario(whole, 5), 2400, stand_at=at)
    standing = [scene for scene in scenes if scene.ego.speed == 0.0][-1200:]
    assert len(standing) == 1200
    for scene in standing:
        people = on_foot(scene)
        poses, extents = people.poses.astype(float), people.extents.astype(float)
        assert not overlap_one(scene.ego.pose, EGO_EXTENT, poses, extents).any()


def test_same_seed_gives_equal_scenes_and_privileged_facts() -> None:
    scenario = Scenario(suite_route("town02-1"), 4)
    seen = []
    for _ in range(2):
        with Simulation(scenario) as simulation:
            for _ in range(100):
                simulation.step(Control(1.0, 0.0))
            seen.append((simulation.scene.actors, simulation.privileged()))
    (one, facts), (other, _) = seen
    assert np.array_equal(one.poses, other.poses)
    assert (np.diff(one.ids) > 0).all()
    assert {ActorKind.CAR, ActorKind.PEDESTRIAN} <= set(one.kinds.tolist())
    assert len(facts.paths) == len(facts.stopped_for) == len(one)
    starts = np.hypot(*(facts.paths[:, 0, :2] - one.poses[:, :2]).T)
    assert np.quantile(starts, 0.9) < 0.6
    parked = one.parked
    assert parked.any()
    assert (facts.desired_speeds[parked] == 0.0).all()


def test_empty_density_has_no_pedestrians_or_parked_cars() -> None:
    with Simulation(replace(Scenario(suite_route("town02-0"), 1), density="empty")) as simulation:
        assert len(simulation.step(Control(0.0, 0.0)).actors) == 0


@pytest.mark.parametrize("name", [f"town0{number}" for number in range(1, 7)])
def test_parked_cars_clear_lanes_and_pedestrians_clear_cars(name: str) -> None:
    places = places_of(name)
    parking = places.parking
    assert bool(len(parking.poses)) == (places.town.life.parking > 0.0)
    assert not parking.edges & set(places.footways.sidewalks)
    roadway = Roadway(places.town)
    for pose, (length, width) in zip(parking.poses, parking.extents, strict=True):
        along = np.linspace(-0.5, 0.5, 9)[:, None] * length
        heading = np.array([np.cos(pose[2]), np.sin(pose[2])])
        left = pose[:2] + 0.5 * width * np.array([-heading[1], heading[0]])
        assert roadway.clearance(left + along * heading).min() > 0.25
