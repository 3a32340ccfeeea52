"""PlanT as a planner: the network plans, `follow_plan` drives, attention tells who matters."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

import plant_bench.features
from plant_bench.agent import Input, Observation, Plan
from plant_bench.data_files import models_dir
from plant_bench.errors import AgentError
from plant_bench.features.inputs import scene_input
from plant_bench.features.tokens import NOWHERE
from plant_bench.world.route import Route

if TYPE_CHECKING:
    from plant_bench.agents.plant.predictor import Predictor

DEFAULT_WEIGHTS = "plant-mini"  # in models/


class PlanT:
    """Learned by imitation: a transformer over nearby vehicles and the route.

    Attributes:
        files: What makes it drive as it does, apart from the code of planners.

    Args:
        weights: Folder of the trained network; `models/plant-mini` without it.
    """

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})
    interval = 2  # ticks: 10 Hz, as PlanT with perception

    def __init__(self, weights: str | None = None) -> None:
        from plant_bench.agents.plant import predictor  # torch is loaded here only

        folder = models_dir() / DEFAULT_WEIGHTS if weights is None else Path(weights)
        self._predictor: Predictor = predictor.Predictor.load(folder)
        self.files: Sequence[Path] = _files(folder)

    def reset(self, route: Route | None) -> None:
        """Start a new episode; there is nothing to forget."""

    def act(self, observation: Observation) -> Plan:
        """Plan the next two seconds."""
        return Plan(self._predictor.waypoints(scene_input(observation, self._predictor.spec)))

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the attention to each actor; who is no token ranks below all, the nearer higher.

        Raises:
            AgentError: The observation holds no objects.
        """
        actors, ego = observation.actors, observation.ego
        if actors is None:
            message = "PlanT needs the input 'objects'."
            raise AgentError(message)
        given = scene_input(observation, self._predictor.spec)
        ranks = -np.hypot(actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y).astype(float)
        told = given.tokens.places != NOWHERE
        ranks[given.tokens.places[told]] = self._predictor.attention(given)[told]
        return ranks


def _files(folder: Path) -> list[Path]:
    features = Path(plant_bench.features.__file__).parent
    return [folder / "weights.safetensors", folder / "config.json", *features.glob("*.py")]
