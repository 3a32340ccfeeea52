"""Which actors matter: rankings that need no planner (PlanT, section 4.2: baselines)."""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Observation
from plant_bench.errors import AgentError

TOUCHING = 0.01  # m, below which distances count alike


class Nearest:
    """Ranks by inverse distance between the centres of the boxes."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return 1/m for each actor.

        Raises:
            AgentError: The observation holds no actors.
        """
        actors, ego = observation.actors, observation.ego
        if actors is None:
            message = "The ranking by distance needs the input 'objects'."
            raise AgentError(message)
        poses = actors.poses.astype(float)
        distance = np.hypot(poses[:, 0] - ego.x, poses[:, 1] - ego.y)
        return 1.0 / np.maximum(distance, TOUCHING)
