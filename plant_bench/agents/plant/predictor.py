"""From one scene to waypoints: the network on one thread, one scene at a time."""

import numpy as np
import torch
from jaxtyping import Float

from plant_bench.agents.plant.network import Batch, PlanTNetwork
from plant_bench.features.network_inputs import SceneInput
from plant_bench.inference_timing import forward_pass


class TorchPredictor:
    """Holds a network; the same input always gives the same answer.

    Args:
        network: In evaluation mode.
    """

    def __init__(self, network: PlanTNetwork) -> None:
        torch.set_num_threads(1)  # one scene is too little work for two; workers share the cores
        self._network = network

    def waypoints(self, given: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        """Return the plan in the ego frame, metres."""
        batch = batch_of_one(given)
        with torch.inference_mode(), forward_pass(len(given.tokens)):
            waypoints, _ = self._network.plan(batch)
        return waypoints[0].double().numpy()

    def attention(self, given: SceneInput) -> Float[np.ndarray, " tokens"]:
        """Return how much [CLS] attends to each token, summed over layers and heads."""
        with torch.inference_mode():
            _, attention = self._network.plan(batch_of_one(given), explain=True)
        assert attention is not None  # noqa: S101  asked for
        return attention[0].double().numpy()


def batch_of_one(given: SceneInput) -> Batch:
    """Return a scene as a batch without padding."""
    return Batch(
        torch.from_numpy(given.tokens.attributes)[None],
        torch.from_numpy(given.tokens.kinds)[None],
        torch.tensor([given.red]),
        torch.tensor([given.target]),
        torch.tensor([given.speed]),
        torch.tensor([given.limit]),
    )
