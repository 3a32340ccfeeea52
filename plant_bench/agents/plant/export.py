"""Writes the graph that `plant_bench.agents.plant.graph` drives with."""

import warnings
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from plant_bench.agents.plant.config import GRAPH_FILE
from plant_bench.agents.plant.graph import ATTENTION, WAYPOINTS
from plant_bench.agents.plant.network import Batch, PlanTNetwork
from plant_bench.agents.plant.weights import load_network
from plant_bench.errors import InputError

OPSET = 17
LEAST_HALVED = 256  # values of a tensor from which on it is stored in half precision
_TRACED_TOKENS = 5  # any number: the graph takes all


class _Plan(nn.Module):
    """`PlanTNetwork.plan` with plain arguments and all answers."""

    def __init__(self, network: PlanTNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, *scene: Tensor) -> tuple[Tensor, Tensor | None]:
        return self.network.plan(Batch(*scene), explain=True)


def export_graph(folder: Path) -> None:
    """Write the graph of a folder's weights beside them.

    Raises:
        InputError: There are no weights, or the package onnx is missing.
    """
    network = load_network(folder)
    some = torch.zeros(1)
    scene = Batch(
        torch.randn(1, _TRACED_TOKENS, 6),
        torch.ones(1, _TRACED_TOKENS, dtype=torch.uint8),
        some,
        torch.zeros(1, 2),
        some + 1.0,
        some + 2.0,
    )
    part = folder / f"{GRAPH_FILE}.part"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the exporter warns of its own age
            torch.onnx.export(
                _Plan(network).eval(),
                tuple(scene),
                str(part),
                input_names=list(Batch._fields),
                output_names=[WAYPOINTS, ATTENTION],
                dynamic_axes={name: {1: "tokens"} for name in ("attributes", "kinds", ATTENTION)},
                opset_version=OPSET,
                dynamo=False,
            )
    except (ImportError, torch.onnx.errors.OnnxExporterError) as error:
        message = f"A graph cannot be written ({error}): pip install 'plant-bench[onnx]'."
        raise InputError(message) from error
    halve_weights(part)
    part.replace(folder / GRAPH_FILE)


def halve_weights(path: Path) -> None:
    """Store a graph's weights in half precision, cast when it is loaded: half the file.

    Nothing is lost where they came from `weights.safetensors`, which holds no more.
    """
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    model = onnx.load(path)
    graph = model.graph
    casts = []
    for weights in graph.initializer:
        values = numpy_helper.to_array(weights)
        if values.dtype != np.float32 or values.size < LEAST_HALVED:
            continue
        name, short = weights.name, f"{weights.name}/half"
        weights.CopyFrom(numpy_helper.from_array(values.astype(np.float16), short))
        casts.append(helper.make_node("Cast", [short], [name], to=TensorProto.FLOAT))
    nodes = [*casts, *graph.node]
    del graph.node[:]
    graph.node.extend(nodes)
    onnx.save(model, path)
