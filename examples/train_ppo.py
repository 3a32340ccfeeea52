"""PPO learns to keep to an empty road, in two processes; minutes on a laptop.

pip install -c constraints.txt '.[gym]' stable-baselines3    # in a checkout of plant-bench
python examples/train_ppo.py --steps 32000 --out ppo.zip
plant-bench score --agent examples/ppo_agent.py:PPOAgent@ppo.zip --routes 0 --repetitions 1
"""

import argparse
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize

import plant_bench.gym  # noqa: F401 - registers the environment

OFF_ROUTE = -1.75  # of Roach's position term: 3.5 m beside the route, where Roach ends an episode


class EndsOffRoute(gymnasium.Wrapper):
    """Ends an episode where there is nothing more to learn."""

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Carry an action out."""
        seen, reward, terminated, truncated, info = self.env.step(action)
        lost = info["reward_terms"]["position"] < OFF_ROUTE
        return seen, reward, terminated or lost, truncated, info


def main() -> None:
    """Train, and say what an episode was worth at the beginning and at the end."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--steps", type=int, default=32_000)
    parser.add_argument("--density", default="empty", help="of the traffic")
    parser.add_argument("--out", default="ppo.zip")
    wanted = parser.parse_args()
    torch.set_num_threads(1)  # the simulations need the other cores
    settings = {
        "town": "town03",
        "density": wanted.density,
        "hazards": False,
        "max_episode_steps": 300,  # 30 s
    }
    env = make_vec_env(
        "PlantBench-v0",
        n_envs=2,
        seed=1,
        vec_env_cls=SubprocVecEnv,
        env_kwargs=settings,
        wrapper_class=EndsOffRoute,
    )
    numbers = ["tokens", "target", "speed", "limit"]
    env = VecNormalize(env, norm_reward=False, norm_obs_keys=numbers)
    model = PPO(
        "MultiInputPolicy",
        env,
        n_steps=512,
        batch_size=128,
        gamma=0.95,
        seed=1,
        policy_kwargs={"log_std_init": -1.0},  # a third of full throttle and steering
    )
    model.learn(4096)
    print(f"first episodes: {_mean_reward(model):.1f}")
    model.learn(max(wanted.steps - 4096, 0), reset_num_timesteps=False)
    print(f"last episodes: {_mean_reward(model):.1f}")
    model.save(wanted.out)
    env.save(str(Path(wanted.out).with_suffix(".vecnormalize.pkl")))  # the policy needs them, too
    env.close()


def _mean_reward(model: PPO) -> float:
    return float(np.mean([item["r"] for item in list(model.ep_info_buffer or ())[-20:]]))


if __name__ == "__main__":
    main()
