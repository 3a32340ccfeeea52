"""Runs PlanT's network with PyTorch on one scene at a time, on one thread."""

import numpy as np
import torch
from jaxtyping import Float

from plant_bench.agents.plant.network import Batch, PlanTNetwork
from plant_bench.features.network_inputs import SceneInput
from plant_bench.inference_timing import forward_pass


class TorchPredictor:
    """Runs a network on one scene; deterministic.

    Args:
        network: The network, in evaluation mode.
    """

    def __init__(self, network: PlanTNetwork) -> None:
        torch.set_num_threads(1)  # one scene is too little work for two; workers share the cores
        self._network = network

    def waypoints(self, scene: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        """Return the plan in the ego frame, metres."""
        batch = batch_of_one(scene)
        with torch.inference_mode(), forward_pass(len(scene.tokens)):
            waypoints, _ = self._network.plan(batch)
        return waypoints[0].double().numpy()

    def attention(self, scene: SceneInput) -> Float[np.ndarray, " tokens"]:
        """Return the attention of [CLS] to each token, summed over layers and heads."""
        with torch.inference_mode():
            _, attention = self._network.plan(batch_of_one(scene), explain=True)
        assert attention is not None  # noqa: S101  explain=True
        return attention[0].double().numpy()


def batch_of_one(scene: SceneInput) -> Batch:
    """Return a scene as a batch without padding."""
    return Batch(
        torch.from_numpy(scene.tokens.attributes)[None],
        torch.from_numpy(scene.tokens.kinds)[None],
        torch.tensor([scene.red]),
        torch.tensor([scene.target]),
        torch.tensor([scene.speed]),
        torch.tensor([scene.limit]),
    )
