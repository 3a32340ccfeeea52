"""PlanT as a planner: the network plans, `follow_plan` drives, attention tells who matters."""

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from plant_bench.agent import Input, NextLight, Observation, Plan
from plant_bench.agents.careful.driver import RESTING_INTERVAL, STILL
from plant_bench.agents.plant.config import GRAPH_FILE, load_config
from plant_bench.controller import follow_plan
from plant_bench.data_files import models_dir
from plant_bench.errors import AgentError
from plant_bench.features.motion import MotionTracker
from plant_bench.features.network_inputs import SceneInput, scene_input
from plant_bench.features.tokens import NO_ROW
from plant_bench.model_folder import CONFIG_FILE, WEIGHTS_FILE
from plant_bench.world.route import Route
from plant_bench.world.scene import Light

DEFAULT_WEIGHTS = "plant-mini"  # in models/
INTERVAL = 2  # ticks between two decisions: 10 Hz, as PlanT with perception
WAITING_INTERVAL = 8  # ticks, at a red light: people take a second to see that it is green


class PlanT:
    """Learned by imitation: a transformer over nearby vehicles and the route.

    Attributes:
        files: What makes it drive as it does, apart from the code of planners.
        libraries: What it computes with.
        interval: Ticks until the next decision.
        tracks: How others have changed in the last half second.

    Args:
        weights: Folder of the trained network; `models/plant-mini` without it.
    """

    inputs = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})

    def __init__(self, weights: str | None = None) -> None:
        folder = models_dir() / DEFAULT_WEIGHTS if weights is None else Path(weights)
        self._spec = load_config(folder).tokens
        self._predictor = load_predictor(folder)
        self.files: Sequence[Path] = _files(folder)
        runs_on = "onnxruntime" if (folder / GRAPH_FILE).is_file() else "torch"
        self.libraries = ("numba", "numpy", runs_on)
        self.motion = MotionTracker()
        self.interval = INTERVAL

    def reset(self, route: Route | None) -> None:
        """Start a new episode; the route is told with each observation."""
        del route
        self.motion.reset()
        self.interval = INTERVAL

    def act(self, observation: Observation) -> Plan:
        """Plan the next two seconds."""
        waypoints = self._predictor.waypoints(self._given(observation))
        plan, ego = Plan(waypoints), observation.ego
        stays = ego.speed < STILL and follow_plan(plan, ego).acceleration <= 0.0
        self.interval = _interval(stays, observation.light)
        return plan

    def __deepcopy__(self, _memo: object) -> "PlanT":
        """Return a copy that shares the network, which never changes."""
        other = copy.copy(self)
        other.motion = self.motion.copied()
        return other

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the attention to each actor; who is no token ranks below all, the nearer higher.

        Raises:
            AgentError: The observation holds no objects.
        """
        actors, ego = observation.actors, observation.ego
        if actors is None:
            message = "PlanT needs the input 'objects'."
            raise AgentError(message)
        given = self._given(observation)
        ranks = -np.hypot(actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y).astype(float)
        told = given.tokens.places != NO_ROW
        ranks[given.tokens.places[told]] = self._predictor.attention(given)[told]
        return ranks

    def _given(self, observation: Observation) -> SceneInput:
        rates = None
        if self._spec.motion and observation.actors is not None:
            rates = self.motion.rates(observation.time, observation.actors)
        return scene_input(observation, self._spec, rates)


def _interval(stays: bool, light: NextLight | None) -> int:
    if not stays:
        return INTERVAL
    return RESTING_INTERVAL if light is None or light.state is not Light.RED else WAITING_INTERVAL


@runtime_checkable
class Predictor(Protocol):
    """Answers one scene; the same scene always gets the same answer."""

    def waypoints(self, given: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        """Return the plan in the ego frame, metres."""
        ...

    def attention(self, given: SceneInput) -> Float[np.ndarray, " tokens"]:
        """Return how much [CLS] attends to each token, summed over layers and heads."""
        ...


def load_predictor(folder: Path) -> Predictor:
    """Return what answers scenes with the weights of a folder: its graph if it holds one.

    Raises:
        InputError: The folder holds no weights that can be used.
    """
    if (folder / GRAPH_FILE).is_file():
        from plant_bench.agents.plant.onnx_network import GraphPredictor

        return GraphPredictor(folder / GRAPH_FILE)
    from plant_bench.agents.plant.network_files import load_network
    from plant_bench.agents.plant.predictor import TorchPredictor  # torch is loaded here only

    return TorchPredictor(load_network(folder))


def _files(folder: Path) -> list[Path]:
    weights = [folder / name for name in (WEIGHTS_FILE, CONFIG_FILE, GRAPH_FILE)]
    return [path for path in weights if path.is_file()]
