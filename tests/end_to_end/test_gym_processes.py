"""The Gymnasium environment in several processes, and PPO of stable-baselines3 learning on it."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecNormalize

import plant_bench
import plant_bench.gym  # registers the environment
from plant_bench.agents.loading.registry import load_agent
from plant_bench.features.raster import RasterSpec
from plant_bench.gym.actions import ControlAction
from plant_bench.gym.encoders import RasterEncoder
from plant_bench.gym.token_encoder import TokenEncoder
from plant_bench.world.route import load_suite

pytestmark = pytest.mark.sumo


STEPS = 15
EXAMPLE = Path(__file__).parents[2] / "examples" / "train_ppo.py"


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """PyTorch on one thread: two wait for each other on a busy machine."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def settings(**more: Any) -> dict[str, Any]:
    return {"town": "town03", "density": "light", **more}


def actions() -> np.ndarray:
    """Return the actions of two environments."""
    wheel = 0.05 * np.random.default_rng(2).standard_normal((STEPS, 2))
    return np.stack((np.full((STEPS, 2), 0.6), wheel), axis=2).astype(np.float32)


def test_parallel_environments_match_sequential_ones() -> None:
    both = gymnasium.make_vec(
        "PlantBench-v0", num_envs=2, vectorization_mode="async", **settings(observation="objects")
    )
    try:
        answers = [both.reset(seed=5)[0], *(both.step(action)[:2] for action in actions())]
    finally:
        both.close()
    alone = gymnasium.make("PlantBench-v0", **settings(observation="objects"))
    for place, seed in enumerate((5, 6)):
        encoded, _ = alone.reset(seed=seed)
        np.testing.assert_equal(encoded, {name: of[place] for name, of in answers[0].items()})
        for action, (seen, rewards) in zip(actions(), answers[1:], strict=True):
            encoded, reward, *_ = alone.step(action[place])
            np.testing.assert_equal(encoded, {name: of[place] for name, of in seen.items()})
            assert reward == rewards[place]
        alone.close()


def test_processes_can_start_during_an_episode_in_the_parent() -> None:
    here = gymnasium.make("PlantBench-v0", **settings())
    here.reset(seed=1)
    here.step(actions()[0, 0])
    one = make_vec_env(
        "PlantBench-v0", n_envs=1, vec_env_cls=SubprocVecEnv, env_kwargs=settings(),
        vec_env_kwargs={"start_method": "fork"},
    )  # fmt: skip
    try:
        one.reset()
        one.step(actions()[0, :1])
        seen, *_ = here.step(actions()[1, 0])
        assert here.observation_space.contains(seen)
    finally:
        one.close()
        here.close()


@pytest.mark.parametrize(
    ("observation", "policy"),
    [("tokens", "MultiInputPolicy"), ("objects", "MultiInputPolicy"), ("raster", "CnnPolicy")],
)
def test_ppo_trains_for_a_few_steps(observation: str, policy: str) -> None:
    small = RasterEncoder(RasterSpec(size=48, scale=1.25, below=12))
    given = small if observation == "raster" else observation
    env = gymnasium.make("PlantBench-v0", **settings(observation=given, density="empty"))
    try:
        model = PPO(policy, env, n_steps=256, batch_size=128, n_epochs=1, seed=1, device="cpu")
        before = [values.detach().clone() for values in model.policy.parameters()]
        model.learn(512)
    finally:
        env.close()
    after = list(model.policy.parameters())
    assert model.num_timesteps == 512
    assert all(values.isfinite().all() for values in after)
    assert any((now != then).any() for now, then in zip(after, before, strict=True))


@pytest.mark.slow
def test_training_example_improves_progress(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLE), "--steps", "32000", "--out", str(tmp_path / "a.zip")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=1500)
    first, last = (float(line.split()[-1]) for line in done.stdout.splitlines())
    assert last > first + 50.0  # measured: -63 at 4,096 steps, 48 at 24,576, 167 at 32,768
    assert (tmp_path / "a.zip").is_file()
    assert (tmp_path / "a.vecnormalize.pkl").is_file()


def test_example_planner_acts_as_its_policy_on_normalised_observations(tmp_path: Path) -> None:
    def make() -> gymnasium.Env:
        return gymnasium.make("PlantBench-v0", **settings(density="empty", hazards=False))

    env = VecNormalize(
        DummyVecEnv([make]), norm_reward=False, norm_obs_keys=["tokens", "target", "speed", "limit"]
    )
    try:
        env.reset()
        model = PPO("MultiInputPolicy", env, n_steps=64, batch_size=64, seed=1, device="cpu")
        model.save(tmp_path / "a.zip")
        env.save(str(tmp_path / "a.vecnormalize.pkl"))
    finally:
        env.close()
    planner = load_agent(f"{EXAMPLE.with_name('ppo_agent.py')}:PPOAgent@{tmp_path / 'a.zip'}")
    route = load_suite("longest6")[12]
    planner.reset(route)
    first = next(iter(plant_bench.drive(planner, route, hazards=False)))
    assert first.observation is not None
    seen = TokenEncoder().encode(first.observation)
    expected, unnormalised = (
        ControlAction().decode(model.predict(given, deterministic=True)[0])
        for given in (env.normalize_obs(seen), seen)
    )
    assert first.action == expected
    assert first.action != unnormalised
    assert [file.name for file in planner.files] == ["a.zip", "a.vecnormalize.pkl"]  # pyright: ignore[reportAttributeAccessIssue]
