"""Runs PlanT's network with ONNX Runtime, in half of PyTorch's time for one scene.

A model folder with `network.onnx` always runs this way, and torch is never loaded: the folder
decides, not the installed packages.
"""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from plant_bench.agents.plant.onnx_file import read_graph
from plant_bench.errors import InputError, in_one_line
from plant_bench.features.network_inputs import SceneInput
from plant_bench.inference_timing import forward_pass

WAYPOINTS, ATTENTION = "waypoints", "attention"
EXPLAIN = "explain"  # input: whether to compute the attention
_INPUTS = {"attributes", "kinds", "red", "target", "speed", "limit", EXPLAIN}
_HOW = "pip install onnxruntime"


class GraphPredictor:
    """Runs an ONNX graph on one scene; deterministic.

    Args:
        path: The graph's file.

    Raises:
        InputError: The graph is broken, or ONNX Runtime is missing.
    """

    def __init__(self, path: Path) -> None:
        try:
            import onnxruntime
        except ImportError as error:
            message = f"{path} needs ONNX Runtime: {_HOW}, or remove the file."
            raise InputError(message) from error
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        try:
            self._session: Any = onnxruntime.InferenceSession(
                read_graph(path), options, providers=["CPUExecutionProvider"]
            )
            self._inputs = [item.name for item in self._session.get_inputs()]
            outputs = {item.name for item in self._session.get_outputs()}
            if not (set(self._inputs) <= _INPUTS and outputs >= {WAYPOINTS, ATTENTION}):
                message = f"inputs {self._inputs} and outputs {sorted(outputs)} are not PlanT's"
                raise ValueError(message)
        except Exception as error:  # its errors share no base but Exception
            message = f"Broken graph {path}: {in_one_line(error)}"
            raise InputError(message) from error

    def waypoints(self, scene: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        """Return the plan in the ego frame, metres."""
        feed = self._feed(scene, _PLAN_ONLY)
        with forward_pass(len(scene.tokens)):
            return self._run(_WAYPOINTS, feed)

    def attention(self, scene: SceneInput) -> Float[np.ndarray, " tokens"]:
        """Return the attention of [CLS] to each token, summed over layers and heads."""
        return self._run(_ATTENTION, self._feed(scene, _PLAN_AND_EXPLAIN))

    def _feed(self, scene: SceneInput, explain: np.ndarray) -> dict[str, np.ndarray]:
        values = {
            "attributes": scene.tokens.attributes[None],
            "kinds": scene.tokens.kinds[None],
            "red": np.array([scene.red], np.float32),
            "target": np.array([scene.target], np.float32),
            "speed": np.array([scene.speed], np.float32),
            "limit": np.array([scene.limit], np.float32),
            EXPLAIN: explain,
        }
        return {name: values[name] for name in self._inputs}

    def _run(self, names: list[str], feed: dict[str, np.ndarray]) -> np.ndarray:
        return self._session.run(names, feed)[0][0].astype(float)


_WAYPOINTS, _ATTENTION = [WAYPOINTS], [ATTENTION]
_PLAN_ONLY, _PLAN_AND_EXPLAIN = np.array([False]), np.array([True])
