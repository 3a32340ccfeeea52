"""PlanT as it is shipped: the network plans, a guard brakes where it must."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Observation
from plant_bench.agents.guarded import Guarded
from plant_bench.agents.plant.agent import PlanT


class GuardedPlanT(Guarded):
    """Learned by imitation, and held back by rules where it would have to brake hard.

    `plant-unguarded` is the network alone, as in the paper.

    Attributes:
        files: What makes it drive as it does, apart from the code of planners.
        libraries: What it computes with.

    Args:
        weights: Folder of the trained network; `models/plant-mini` without it.
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
            AgentError: The observation holds no objects.
        """
        return self._ranker.rank(observation)
