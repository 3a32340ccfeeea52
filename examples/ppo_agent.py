"""A planner that drives with a policy of `train_ppo.py`: PPO and the statistics of VecNormalize.

python examples/train_ppo.py --steps 32000 --out ppo.zip
plant-bench score --agent examples/ppo_agent.py:PPOAgent@ppo.zip --routes 0 --repetitions 1
"""

import pickle
from pathlib import Path

import torch
from stable_baselines3 import PPO

from plant_bench.agent import Control, Input, Observation, Plan
from plant_bench.gym.actions import ControlAction
from plant_bench.gym.token_encoder import TokenEncoder
from plant_bench.world.route import Route

FRAME_SKIP = 2  # ticks per decision, as in the environment's default


class PPOAgent:
    """Encodes observations as the environment does, normalises them, and asks the policy."""

    inputs = frozenset({Input.ROUTE, Input.OBJECTS, Input.LIGHT})
    interval = FRAME_SKIP

    def __init__(self, policy: str) -> None:
        statistics = Path(policy).with_suffix(".vecnormalize.pkl")
        self.files = [Path(policy), statistics]  # they count in the planner's checksum
        torch.set_num_threads(1)
        self._policy = PPO.load(policy, device="cpu")
        with statistics.open("rb") as file:  # a pickle can run code: load only your own
            self._normaliser = pickle.load(file)
        self._encoder, self._action = TokenEncoder(), ControlAction()

    def reset(self, route: Route | None) -> None:
        """Start a new episode; the tokens have no memory."""

    def act(self, observation: Observation) -> Plan | Control:
        """Return the control that the policy prefers."""
        seen = self._normaliser.normalize_obs(self._encoder.encode(observation))
        action, _ = self._policy.predict(seen, deterministic=True)
        return self._action.decode(action)
