"""The Gymnasium environment: contract, equal scores, repeatability, one episode at a time.

Tests with several processes are in tests/end_to_end/test_gym_processes.py.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import plant_bench.gym
from plant_bench.agent import Plan
from plant_bench.agents.loading.registry import load_agent
from plant_bench.data_files import TOWNS_VARIABLE
from plant_bench.errors import InputError
from plant_bench.features.raster import RasterSpec
from plant_bench.gym.actions import ControlAction
from plant_bench.gym.encoders import RasterEncoder
from plant_bench.gym.environment import PlantBenchEnv
from plant_bench.runner.episode.jobs import Job, repetition_seed
from plant_bench.runner.episode.loop import run_episode
from plant_bench.scoring.infractions import Status
from plant_bench.sensing.inputs import restrict
from plant_bench.world.route import ROUTE_FORMAT, Route, load_suite
from plant_bench.world.town import town_file

pytestmark = pytest.mark.sumo

DRIVERS = '''
"""Drivers whose answers are numbers that the environment's float32 can hold."""

import numpy as np

from plant_bench.agent import Control, Input, Plan
from plant_bench.agents.idm_follower import IdmFollower
from plant_bench.geometry.pose import to_frame
from plant_bench.gym.actions import ControlAction


class Controls(IdmFollower):
    def act(self, observation):
        kind = ControlAction()
        return kind.decode(kind.encode(super().act(observation)))


class Plans:
    inputs = frozenset({Input.ROUTE})
    interval = 2

    def reset(self, route):
        pass

    def act(self, observation):
        ahead = np.minimum([4, 8, 12, 16], len(observation.route.points) - 1)
        points = to_frame(observation.route.points[ahead], *observation.ego.pose)
        return Plan(points.astype(np.float32).astype(float))
'''


@pytest.fixture
def make() -> Iterator[Callable[..., PlantBenchEnv]]:
    """Environments that are closed after the test."""
    made: list[gymnasium.Env] = []

    def one(**settings: Any) -> PlantBenchEnv:
        made.append(gymnasium.make("PlantBench-v0", **{"town": "town03", **settings}))
        env = made[-1].unwrapped
        assert isinstance(env, PlantBenchEnv)
        return env

    yield one
    for env in made:
        env.close()


@pytest.fixture
def short(tmp_path: Path, beginning: Callable[[int], Route]) -> tuple[str, Route]:
    """A suite of one route of 120 m, and that route."""
    path = tmp_path / "short.json"
    path.write_text(json.dumps({"format": 1, "routes": [beginning(120).to_payload()]}))
    return str(path), load_suite(str(path))[0]


@pytest.mark.parametrize("action", ["control", "plan"])
@pytest.mark.parametrize("observation", ["tokens", "objects", "raster"])
def test_gymnasium_check_env_passes(
    make: Callable[..., PlantBenchEnv], observation: str, action: str
) -> None:
    check_env(make(observation=observation, action=action, density="empty"))


def test_environment_is_found_by_its_module() -> None:
    env = gymnasium.make("plant_bench.gym:PlantBench-v0", routes="0")
    assert env.spec is not None
    assert env.spec.id == plant_bench.gym.ENV_ID


@pytest.mark.parametrize(("driver", "action"), [("Controls", "control"), ("Plans", "plan")])
def test_environment_episode_scores_like_the_score_command(
    make: Callable[..., PlantBenchEnv],
    tmp_path: Path,
    short: tuple[str, Route],
    driver: str,
    action: str,
) -> None:
    (tmp_path / "drivers.py").write_text(DRIVERS)
    suite, route = short
    spec = f"{tmp_path / 'drivers.py'}:{driver}"
    job = Job(spec, "", route, 2, repetition_seed(0, route.id, 2), "dense")
    scored = run_episode(job).result

    env, agent = make(suite=suite, action=action), load_agent(spec)
    env.reset(options={"repetition": 2})
    agent.reset(route.plan)
    over = False
    info: dict[str, Any] = {}
    while not over:
        given = agent.act(restrict(env.observation, agent.inputs))
        asked = given.waypoints if isinstance(given, Plan) else ControlAction().encode(given)
        _, _, terminated, truncated, info = env.step(asked)
        over = terminated or truncated
    assert env.result is not None
    named = {"agent": spec, "inputs": scored.inputs}
    assert env.result.model_copy(update=named) == scored
    assert scored.status is Status.COMPLETED
    assert info["status"] == scored.status
    assert info["score"] == {
        "DS": scored.driving_score,
        "RC": scored.route_completion,
        "IS": scored.infraction_score,
    }


def drive(env: PlantBenchEnv, steps: int, **how: Any) -> list[Any]:
    """Return the observations and rewards of an environment for fixed actions."""
    answers: list[Any] = [env.reset(**how)]
    actions = np.random.default_rng(1)
    for _ in range(steps):
        answers.append(env.step(np.array([0.5, 0.02 * actions.standard_normal()], np.float32)))
    return answers


def test_equal_seeds_and_actions_give_equal_steps(make: Callable[..., PlantBenchEnv]) -> None:
    env = make(observation="objects")
    one, two = drive(env, 20, seed=3), drive(env, 20, seed=3)
    np.testing.assert_equal(one, two)
    assert drive(env, 0, seed=4)[0][1]["seed"] != one[0][1]["seed"]


def test_reset_without_a_seed_starts_another_episode(make: Callable[..., PlantBenchEnv]) -> None:
    env = make()
    _, first = env.reset(seed=3)
    _, second = env.reset()
    assert first["seed"] != second["seed"]


def test_time_budget_truncates_the_episode(
    make: Callable[..., PlantBenchEnv], short: tuple[str, Route]
) -> None:
    env = make(suite=short[0], frame_skip=20, density="empty", reward="progress")
    env.reset(seed=1)
    steps, terminated, truncated = 0, False, False
    info: dict[str, Any] = {}
    while not (terminated or truncated):
        _, reward, terminated, truncated, info = env.step(np.array([-1.0, 0.0], np.float32))
        assert reward == 0.0  # it stands
        steps += 1
    assert (terminated, truncated) == (False, True)
    assert info["infractions"]["timeout"] == 1
    assert steps == pytest.approx(0.8 * 120 + 5, abs=2)  # seconds, one a step


def test_leaving_the_route_terminates_with_a_penalty(make: Callable[..., PlantBenchEnv]) -> None:
    env = make(density="empty", frame_skip=10)
    env.reset(seed=1)
    terms: list[dict[str, float]] = []
    terminated = truncated = False
    info: dict[str, Any] = {}
    while not (terminated or truncated):
        away = -1.0 if len(terms) < 8 else 0.0  # a turn to the right, and straight on
        _, _, terminated, truncated, info = env.step(np.array([0.4, 0.5 * away], np.float32))
        terms.append(info["reward_terms"])
    assert terminated
    assert info["status"] == Status.DEVIATED
    assert info["infractions"]["route_deviation"] == 1
    assert terms[-1]["terminal"] <= -1.0


def test_second_running_episode_in_one_process_is_refused(
    make: Callable[..., PlantBenchEnv],
) -> None:
    one, two = make(), make()
    still = np.zeros(2, np.float32)
    one.reset(seed=1)
    one.step(still)
    with pytest.raises(InputError, match="SubprocVecEnv"):
        two.reset()
    one.step(still)  # goes on unharmed
    one.close()
    two.reset()
    with pytest.raises(InputError, match="reset"):
        one.step(still)


def test_episode_without_steps_is_replaced_by_another_environment(
    make: Callable[..., PlantBenchEnv],
) -> None:
    one, two = make(), make()
    one.reset(seed=1)
    two.reset(seed=1)
    two.step(np.zeros(2, np.float32))
    with pytest.raises(InputError, match="SubprocVecEnv"):
        one.step(np.zeros(2, np.float32))


def suite_in_a_town_of_its_own(folder: Path, number: int) -> str:
    """Write a suite of one route in a copy of its town that is called theirs."""
    route = load_suite("longest6")[number]
    town = folder / "towns" / "theirs"
    town.mkdir(parents=True)
    text = town_file(route.town).read_text(encoding="utf-8")
    (town / "town.json").write_text(text.replace(f'"name":"{route.town}"', '"name":"theirs"', 1))
    net = town_file(route.town).with_name("town.net.xml")
    (town / net.name).write_bytes(net.read_bytes())
    payload = {"format": ROUTE_FORMAT, "routes": [replace(route, town="theirs").to_payload()]}
    (folder / "routes.json").write_text(json.dumps(payload), encoding="utf-8")
    return str(folder)


def test_two_suites_can_have_towns_with_the_same_name(
    make: Callable[..., PlantBenchEnv], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(TOWNS_VARIABLE, "")
    suites = [suite_in_a_town_of_its_own(tmp_path / str(n), n) for n in (6, 12)]
    settings = {"town": "theirs", "density": "empty", "hazards": False, "observation": "raster"}

    one, _ = [make(suite=suite, **settings) for suite in suites]
    seen, _ = one.reset(seed=1)

    alone, _ = make(suite=suites[0], **settings).reset(seed=1)
    assert seen[0].any()
    np.testing.assert_array_equal(seen, alone)


def test_rendering_shows_a_birds_eye_view(make: Callable[..., PlantBenchEnv]) -> None:
    env = make(render_mode="rgb_array")
    with pytest.raises(InputError, match="reset"):
        env.render()
    env.reset(seed=1)
    shown = env.render()
    assert (shown.shape, shown.dtype) == ((512, 512, 3), np.uint8)
    assert len(np.unique(shown.reshape(-1, 3), axis=0)) >= 4  # ground, road, route, ego


def test_custom_encoder_and_reward_are_used(make: Callable[..., PlantBenchEnv]) -> None:
    tiny = RasterEncoder(RasterSpec(size=32, scale=1.0, below=8))
    env = make(observation=tiny, reward=lambda step: {"speed": step.after.ego.speed})
    encoded, _ = env.reset(seed=1)
    _, reward, _, _, info = env.step(np.array([1.0, 0.0], np.float32))
    assert encoded.shape == (8, 32, 32)
    assert reward == info["reward_terms"]["speed"] > 0.0


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"town": "town3"}, "town01, town02"),
        ({"suite": "longest7"}, "longest6"),
        ({"routes": "town03-77"}, "Did you mean"),
        ({"observation": "pixels"}, "tokens, objects, raster"),
        ({"action": "wheel"}, "control, plan"),
        ({"reward": "raoch"}, "roach, progress"),
        ({"density": "thick"}, "dense"),
        ({"frame_skip": 0}, "1 to 20"),
    ],
)
def test_unknown_setting_lists_the_valid_ones(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        PlantBenchEnv(**settings)


def test_wrong_option_or_missing_reset_says_what_to_do(make: Callable[..., PlantBenchEnv]) -> None:
    env = make()
    with pytest.raises(InputError, match="reset"):
        env.step(np.zeros(2, np.float32))
    with pytest.raises(InputError, match="route, repetition"):
        env.reset(options={"rout": "town03-1"})
    with pytest.raises(InputError, match="town03-1"):
        env.reset(options={"route": "town01-0"})
