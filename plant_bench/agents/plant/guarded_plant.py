"""The planner `plant`: PlanT with the rule-based safety layer."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Observation
from plant_bench.agents.guarded import Guarded
from plant_bench.agents.plant.agent import PlanT


class GuardedPlanT(Guarded):
    """Learned by imitation, with a rule-based safety layer that brakes in emergencies.

    `plant-unguarded` is the network alone, as in the paper.

    Attributes:
        files: The model's files; the planner's checksum covers them and its code.
        libraries: The packages that it computes with.

    Args:
        weights: Folder of the trained network; `models/plant-mini` by default.
    """

    inputs = PlanT.inputs

    def __init__(self, weights: str | None = None) -> None:
        planner = PlanT(weights)
        super().__init__(planner, planner.motion)
        self._ranker = planner
        self.files: Sequence[Path] = planner.files
        self.libraries = planner.libraries

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the attention to each actor, as `PlanT.rank`.

        Raises:
            AgentError: The observation has no objects.
        """
        return self._ranker.rank(observation)
