"""The network as a graph for ONNX Runtime, which needs half of PyTorch's time for one scene.

A folder of weights that holds `network.onnx` is driven with it, and torch is never loaded; so the
folder decides how an agent drives, not what happens to be installed.
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
EXPLAIN = "explain"  # the input that tells whether attention is computed
_INPUTS = {"attributes", "kinds", "red", "target", "speed", "limit", EXPLAIN}
_HOW = "pip install onnxruntime"


class GraphPredictor:
    """Holds a graph; the same input always gives the same answer.

    Args:
        path: Of the graph.

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
            self._wanted = [item.name for item in self._session.get_inputs()]
            given = {item.name for item in self._session.get_outputs()}
            if not (set(self._wanted) <= _INPUTS and given >= {WAYPOINTS, ATTENTION}):
                message = f"inputs {self._wanted} and outputs {sorted(given)} are not PlanT's"
                raise ValueError(message)
        except Exception as error:  # its errors share no base but Exception
            message = f"Broken graph {path}: {in_one_line(error)}"
            raise InputError(message) from error

    def waypoints(self, given: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        """Return the plan in the ego frame, metres."""
        feed = self._feed(given, _PLAN_ONLY)
        with forward_pass(len(given.tokens)):
            return self._run(_WAYPOINTS, feed)

    def attention(self, given: SceneInput) -> Float[np.ndarray, " tokens"]:
        """Return how much [CLS] attends to each token, summed over layers and heads."""
        return self._run(_ATTENTION, self._feed(given, _PLAN_AND_EXPLAIN))

    def _feed(self, given: SceneInput, explain: np.ndarray) -> dict[str, np.ndarray]:
        scene = {
            "attributes": given.tokens.attributes[None],
            "kinds": given.tokens.kinds[None],
            "red": np.array([given.red], np.float32),
            "target": np.array([given.target], np.float32),
            "speed": np.array([given.speed], np.float32),
            "limit": np.array([given.limit], np.float32),
            EXPLAIN: explain,
        }
        return {name: scene[name] for name in self._wanted}

    def _run(self, names: list[str], feed: dict[str, np.ndarray]) -> np.ndarray:
        return self._session.run(names, feed)[0][0].astype(float)


_WAYPOINTS, _ATTENTION = [WAYPOINTS], [ATTENTION]
_PLAN_ONLY, _PLAN_AND_EXPLAIN = np.array([False]), np.array([True])
