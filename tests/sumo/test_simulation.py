"""The simulated world: repeatable, reacting to the ego, and no actor appears in its sight."""

import hashlib
import multiprocessing
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path

import numpy as np
import pytest

from plant_bench.agent import Control
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.scoring.referee import Referee
from plant_bench.sim.ego import advance
from plant_bench.sim.simulation import LEVEL_GAP, Simulation
from plant_bench.sim.traffic import SIGHT
from plant_bench.world.route import Route, Scenario, load_suite
from plant_bench.world.scene import EGO_LENGTH, TICK, Light, Scene
from plant_bench.world.town import load_town
from tests.builders import suite_route
from tests.sumo import driving

pytestmark = pytest.mark.sumo


def short(name: str, length: int) -> Route:
    """The first metres of a route."""
    whole = suite_route(name)
    return replace(
        whole,
        id=f"{name}-short",
        points=whole.points[: length + 1],
        elevations=whole.elevations[: length + 1],
        speed_limits=whole.speed_limits[: length + 1],
        passages=tuple(passage for passage in whole.passages if passage.exit < length),
    )


def drive(scenario: Scenario, agent: str, ticks: int) -> list[Scene]:
    with Simulation(scenario) as simulation:
        drive = islice(driving.drive(simulation, scenario.route, agent), ticks + 1)
        return [simulation.scene for _ in drive]


def fingerprint(folder: str, name: str, seed: int) -> str:
    """Drive an episode, and hash its record and recording."""
    file = Path(folder) / f"{name}-{seed}.parquet"
    job = Job("expert", agent_checksum("expert"), short(name, 200), 0, seed, "dense")
    episode = run_episode(job, recording=file)
    digest = hashlib.sha256(episode.result.to_json().encode())
    digest.update(file.read_bytes())
    return digest.hexdigest()


def _fingerprints(folder: str, jobs: list[tuple[str, int]]) -> list[str]:
    return [fingerprint(folder, name, seed) for name, seed in jobs]


def test_same_scenario_is_bit_identical_across_processes_and_order(tmp_path: Path) -> None:
    jobs = [("town02-0", 1), ("town02-0", 2), ("town01-5", 1)]
    context = multiprocessing.get_context("spawn")
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    with context.Pool(1) as one, context.Pool(1) as other:
        first = one.apply_async(_fingerprints, (str(tmp_path / "a"), jobs))
        second = other.apply_async(_fingerprints, (str(tmp_path / "b"), jobs[::-1]))
        assert first.get(200) == second.get(200)[::-1]
        assert len(set(first.get())) == 3


def away(scene: Scene) -> np.ndarray:
    """Return the distance from the ego to each actor; to vehicles between fronts, as SUMO does."""
    actors, ego = scene.actors, scene.ego
    yaws = np.append(actors.poses[:, 2], ego.yaw)
    halves = 0.5 * np.append(actors.extents[:, 0], EGO_LENGTH)[:, None]
    centres = np.vstack((actors.poses[:, :2], (ego.x, ego.y)))
    fronts = centres + halves * np.stack((np.cos(yaws), np.sin(yaws)), axis=1)
    points = np.where(actors.in_traffic[:, None], fronts[:-1], centres[:-1])
    origins = np.where(actors.in_traffic[:, None], fronts[-1], centres[-1])
    return np.hypot(*(points - origins).T)


def test_actors_do_not_appear_or_vanish_in_sight() -> None:
    scenes = drive(Scenario(suite_route("town05-0"), 3), "expert", 2400)
    comings: set[int] = set()
    for before, after in pairwise(scenes):
        for here, there in ((before, after), (after, before)):
            odd = ~np.isin(here.actors.ids, there.actors.ids)
            comings.update(here.actors.ids[odd].tolist())
            assert away(here)[odd].min(initial=SIGHT) > SIGHT - 4.5  # what two fast ones close
    assert len(comings) > 20


def test_traffic_is_dense_and_actors_move_at_their_speed() -> None:
    scenes = drive(Scenario(suite_route("town05-0"), 3), "expert", 1200)
    assert np.mean([len(scene.actors) for scene in scenes]) > 6.0
    jumps, limits = [], []
    for before, after in pairwise(scenes):
        _, here, there = np.intersect1d(before.actors.ids, after.actors.ids, return_indices=True)
        moved = after.actors.poses[there, :2] - before.actors.poses[here, :2]
        jumps.append(np.hypot(*moved.T) - TICK * after.actors.speeds[there])
        # SUMO turns a long vehicle about its front at once when its rear changes lanes.
        limits.append(np.where(after.actors.extents[there, 0] > 6.0, 0.8, 0.35))
    assert (np.abs(np.concatenate(jumps)) < np.concatenate(limits)).all()


def test_followers_stop_behind_a_stationary_ego() -> None:
    scenario = Scenario(suite_route("town05-0"), 3)
    with Simulation(scenario) as simulation:
        scene = simulation.scene
        for _ in range(1200):
            scene = simulation.step(Control(0.0, 0.0))
    ego = scene.ego
    forward = np.array([np.cos(ego.yaw), np.sin(ego.yaw)])
    offset = scene.actors.poses[:, :2] - (ego.x, ego.y)
    along, aside = offset @ forward, np.abs(offset @ (-forward[1], forward[0]))
    behind = (along < 0.0) & (along > -12.0) & (aside < 1.0)
    assert behind.any()
    assert along[behind].max() < -4.5  # no box reaches the ego's
    assert scene.actors.speeds[behind].max() < 0.1


def test_empty_density_has_no_traffic_and_unknown_density_is_refused() -> None:
    assert len(drive(Scenario(suite_route("town02-0"), 1, "empty"), "cruise", 5)[-1].actors) == 0
    with pytest.raises(InputError, match="Densities"):
        Simulation(Scenario(suite_route("town02-0"), 1, "thick"))


def test_simulation_can_start_after_a_failed_scenario() -> None:
    broken = replace(suite_route("town02-0"), edges=("no-such-edge",))
    with pytest.raises(SimulationError, match="ego"):
        Simulation(Scenario(broken, 1))
    assert drive(Scenario(suite_route("town02-0"), 1, "empty"), "cruise", 5)


def test_ego_state_follows_the_bicycle_model_exactly() -> None:
    scenario = Scenario(suite_route("town02-0"), 1, "empty")
    with Simulation(scenario) as simulation:
        ego = simulation.scene.ego
        for _ in range(40):
            control = Control(2.0, 0.05)
            ego = advance(ego, control)
            assert simulation.step(control).ego == ego


def test_lights_are_visible_when_near_and_change() -> None:
    whole = suite_route("town02-0")
    passage = whole.signal_passages[0]
    scenes = drive(Scenario(whole, 1, "empty"), "cruise", 1500)
    shown = {int(scene.lights[0]) for scene in scenes}
    assert {Light.UNKNOWN} < shown or passage.entry < 60.0
    assert len(shown) > 1


def test_privileged_paths_start_at_the_actors_and_are_followed() -> None:
    scenario = Scenario(suite_route("town05-1"), 2)
    driver = load_agent("expert")
    driver.reset(scenario.route)
    starts, errors = [], []
    with Simulation(scenario) as simulation:
        for _ in range(200):
            simulation.step(Control(0.0, 0.0))
        for _ in range(20):
            scene, facts = simulation.scene, simulation.privileged()
            starts.append(np.hypot(*(facts.paths[:, 0, :2] - scene.actors.poses[:, :2]).T))
            later = scene
            for _ in range(30):
                later = simulation.step(Control(0.0, 0.0))
            _, here, there = np.intersect1d(scene.actors.ids, later.actors.ids, return_indices=True)
            places = later.actors.poses[there, :2]
            paths = facts.paths[here, :, :2]
            distance = np.hypot(*np.moveaxis(paths - places[:, None], 2, 0)).min(axis=1)
            errors.append(distance)
    assert np.quantile(np.concatenate(starts), 0.95) < 0.5
    assert np.quantile(np.concatenate(errors), 0.9) < 0.6


def test_actors_on_another_level_are_out_of_sight() -> None:
    """Town04's highway crosses itself: there are no collisions through the bridge."""
    town = load_town("town04")
    crossing = next(
        item
        for item in load_suite("longest6")
        if item.town == "town04" and np.ptp(item.elevations) > 2.0
    )
    assert np.ptp([lane.points[:, 2].max() for lane in town.lanes.values()]) > LEVEL_GAP
    scenes = drive(Scenario(crossing, 4), "expert", 2400)
    referee = Referee(town, crossing)
    for scene in scenes:
        referee.judge(scene)
    assert referee.infractions == []
