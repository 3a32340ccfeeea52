"""The planner `plant-unguarded`: PlanT's network plans; its attention ranks the actors."""

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
WAITING_INTERVAL = 8  # ticks, at a red light: a human driver, too, starts with a delay


class PlanT:
    """Learned by imitation: a transformer over nearby vehicles and the route.

    Attributes:
        files: The model's files; the planner's checksum covers them and its code.
        libraries: The packages that it computes with.
        interval: Ticks until the next decision.
        motion: The actors' motion over the last half second.

    Args:
        weights: Folder of the trained network; `models/plant-mini` by default.
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
        """Start a new episode; the route comes with each observation."""
        del route
        self.motion.reset()
        self.interval = INTERVAL

    def act(self, observation: Observation) -> Plan:
        """Plan the next two seconds."""
        waypoints = self._predictor.waypoints(self._scene(observation))
        plan, ego = Plan(waypoints), observation.ego
        stays = ego.speed < STILL and follow_plan(plan, ego).acceleration <= 0.0
        self.interval = _interval(stays, observation.light)
        return plan

    def __deepcopy__(self, _memo: object) -> "PlanT":
        """Return a copy that shares the network, which is immutable."""
        other = copy.copy(self)
        other.motion = self.motion.copied()
        return other

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the attention to each actor.

        Actors without a token rank below all others, nearer ones higher.

        Raises:
            AgentError: The observation has no objects.
        """
        actors, ego = observation.actors, observation.ego
        if actors is None:
            message = "PlanT needs the input 'objects'."
            raise AgentError(message)
        scene = self._scene(observation)
        ranks = -np.hypot(actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y).astype(float)
        is_actor = scene.tokens.places != NO_ROW
        ranks[scene.tokens.places[is_actor]] = self._predictor.attention(scene)[is_actor]
        return ranks

    def _scene(self, observation: Observation) -> SceneInput:
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
    """Runs the network on one scene; deterministic."""

    def waypoints(self, scene: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        """Return the plan in the ego frame, metres."""
        ...

    def attention(self, scene: SceneInput) -> Float[np.ndarray, " tokens"]:
        """Return the attention of [CLS] to each token, summed over layers and heads."""
        ...


def load_predictor(folder: Path) -> Predictor:
    """Return a predictor for a model folder: its ONNX graph if there is one, else PyTorch.

    Raises:
        InputError: The folder has no usable weights.
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
