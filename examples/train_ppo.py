"""PPO learns to keep to an empty road, in two processes; minutes on a laptop.

pip install 'plant-bench[gym]' stable-baselines3
python examples/train_ppo.py --steps 20000 --out ppo.zip
"""

import argparse

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize

import plant_bench.gym  # noqa: F401 - registers the environment


def main() -> None:
    """Train, and say what an episode was worth at the beginning and at the end."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--density", default="empty", help="of the traffic")
    parser.add_argument("--reward", default="roach")
    parser.add_argument("--out", default="ppo.zip")
    wanted = parser.parse_args()
    torch.set_num_threads(1)  # the simulations need the other cores
    settings = {
        "town": "town03",
        "density": wanted.density,
        "hazards": False,
        "reward": wanted.reward,
        "max_episode_steps": 300,  # 30 s
    }
    env = make_vec_env(
        "PlantBench-v0", n_envs=2, seed=1, vec_env_cls=SubprocVecEnv, env_kwargs=settings
    )
    numbers = ["tokens", "target", "speed", "limit"]
    env = VecNormalize(env, norm_reward=False, norm_obs_keys=numbers)
    model = PPO("MultiInputPolicy", env, n_steps=512, batch_size=128, gamma=0.95, seed=1)
    model.learn(4096)
    print(f"first episodes: {_mean_reward(model):.1f}")
    model.learn(max(wanted.steps - 4096, 0), reset_num_timesteps=False)
    print(f"last episodes: {_mean_reward(model):.1f}")
    model.save(wanted.out)
    env.close()


def _mean_reward(model: PPO) -> float:
    return float(np.mean([item["r"] for item in list(model.ep_info_buffer or ())[-20:]]))


if __name__ == "__main__":
    main()
