"""Builds the ONNX graph of PlanT's network node by node; `agents.plant.onnx_network` runs it.

It is not traced by torch: a traced graph has three times the nodes, most of them to compute shapes
that are known here, and takes a fifth more time to run.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plant_bench.agent import PLAN_STEPS
from plant_bench.agents.plant.config import GRAPH_BITS, GRAPH_FILE, GraphBits, PlanTConfig
from plant_bench.agents.plant.network import DECODER_WIDTH, METRES, SPEED, scales_of
from plant_bench.agents.plant.network_files import load_network
from plant_bench.agents.plant.onnx_network import ATTENTION, EXPLAIN, WAYPOINTS
from plant_bench.agents.plant.transformer import NORM_EPSILON
from plant_bench.atomic_files import write_whole
from plant_bench.errors import InputError

if TYPE_CHECKING:
    from plant_bench.agents.plant.onnx_builder import GraphWriter

_STATE = DECODER_WIDTH + 1  # width of the GRU's state: the decoder's, and the red light
_END = np.iinfo(np.int64).max  # ends a slice after the last row


def export_graph(folder: Path, bits: GraphBits = GRAPH_BITS) -> None:
    """Write a model folder's ONNX graph.

    Args:
        folder: The model folder.
        bits: Bits per weight of the encoder's layers; with 8, the graph is up to twice as fast,
            and waypoints differ by millimetres.

    Raises:
        InputError: There are no weights, or the package onnx is missing.
    """
    network = load_network(folder)
    try:
        from plant_bench.agents.plant.onnx_builder import GraphWriter
    except ImportError as error:
        message = (
            f"A graph cannot be written ({error}). Install the package: pip install '.[onnx]' in a "
            "checkout of plant-bench."
        )
        raise InputError(message) from error
    weights = {name: values.numpy() for name, values in network.state_dict().items()}
    writer = GraphWriter()
    _Export(writer, network.config, weights, bits).add_plan()
    write_whole(folder / GRAPH_FILE, writer.write)


class _Export:
    """Builds `PlanTNetwork.plan` for one scene; hidden states are (tokens, width), [CLS] first."""

    def __init__(
        self,
        writer: "GraphWriter",
        config: PlanTConfig,
        weights: dict[str, np.ndarray],
        bits: GraphBits,
    ) -> None:
        self._writer = writer
        self._config = config
        self._weights = weights
        self._size = config.encoder
        self._in_layers = writer.linear if bits == 32 else writer.quantised_linear

    def add_plan(self) -> None:
        """Add the whole graph, from the inputs to waypoints and attention."""
        writer, hidden = self._writer, self._embedded()
        projections: list[tuple[str, str]] = []
        for place in range(self._size.layers):
            last = place == self._size.layers - 1  # only its [CLS] is decoded
            name = f"encoder.layers.{place}"
            hidden, query, key = self._layer(name, hidden, first_only=last)
            projections.append((query, key))
        self._decode(hidden)
        explain = writer.add_input(EXPLAIN, np.bool_, 1)
        writer.add_if(explain, self._explanation(projections), self._no_explanation(), ATTENTION)
        writer.add_output(WAYPOINTS, 1, PLAN_STEPS, 2)
        writer.add_output(ATTENTION, 1, "seen")

    def _embedded(self) -> str:
        writer = self._writer
        count = self._config.tokens.attributes
        attributes = writer.add_input("attributes", np.float32, 1, "tokens", count)
        kinds = writer.add_input("kinds", np.uint8, 1, "tokens")
        rows = writer.reshape(attributes, -1, count)
        projected = self._linear("project", self._divided(rows, scales_of(self._config.tokens)))
        table = writer.constant(self._weights["kinds.weight"])
        types = writer.add("Gather", table, writer.cast(writer.reshape(kinds, -1), np.int64))
        tokens = writer.add("Add", projected, types)
        whole = writer.add("Concat", self._cls(), tokens, axis=0)
        norm = self._constants("encoder.norm.weight", "encoder.norm.bias")
        return writer.add("LayerNormalization", whole, *norm, axis=-1, epsilon=NORM_EPSILON)

    def _cls(self) -> str:
        writer, facts = self._writer, []
        cls = writer.constant(self._weights["cls"][None])
        if self._config.speed_input:
            speed = writer.add_input("speed", np.float32, 1)
            unknown, zero = writer.add("IsNaN", speed), writer.constant(np.zeros(1))
            facts.append(self._divided(writer.add("Where", unknown, zero, speed), (SPEED,)))
            facts.append(writer.cast(writer.add("Not", unknown), np.float32))
        if self._config.limit_input:
            limit = writer.add_input("limit", np.float32, 1)
            facts.append(self._divided(limit, (SPEED,)))
        if not facts:
            return cls
        row = writer.reshape(writer.add("Concat", *facts, axis=0), 1, -1)
        return writer.add("Add", cls, self._linear("facts", row))

    def _layer(self, name: str, hidden: str, *, first_only: bool) -> tuple[str, str, str]:
        """Return the new hidden states (with `first_only`, of [CLS] alone), queries and keys."""
        writer, width = self._writer, self._size.width
        updated = writer.rows(hidden, 0, 1) if first_only else hidden
        query, key, value = (
            self._in_layer(f"{name}.query_key_value", some, slice(part * width, (part + 1) * width))
            for part, some in enumerate((updated, hidden, hidden))
        )
        batches = (writer.reshape(some, 1, -1, width) for some in (query, key, value))
        mixed = writer.add("MultiHeadAttention", *batches, num_heads=self._size.heads)
        mixed = self._in_layer(f"{name}.mix", writer.reshape(mixed, -1, width))
        middle = self._added(f"{name}.attention_norm", mixed, updated)
        widened = writer.add("Gelu", self._in_layer(f"{name}.widen", middle))
        out = self._added(f"{name}.norm", self._in_layer(f"{name}.narrow", widened), middle)
        return out, query, key

    def _explanation(self, projections: list[tuple[str, str]]) -> "GraphWriter":
        """Return the branch that sums the attention of [CLS] to the tokens over layers and heads.

        Args:
            projections: Queries and keys of each layer.
        """
        branch = type(self._writer)("explained/")
        heads, depth = self._size.heads, self._size.width // self._size.heads
        root, axes = branch.constant(np.array([depth**0.5])), branch.constant(np.array([0, 1]))
        seen: list[str] = []
        for query, key in projections:
            first = branch.reshape(branch.rows(query, 0, 1), heads, 1, depth)
            keys = branch.add("Transpose", branch.reshape(key, -1, heads, depth), perm=[1, 2, 0])
            scores = branch.add("Div", branch.add("MatMul", first, keys), root)
            weights = branch.add("Softmax", scores, axis=-1)
            seen.append(branch.add("ReduceSum", weights, axes, keepdims=0))
        others = branch.rows(branch.add("Sum", *seen), 1, _END)
        branch.add_output(branch.reshape(others, 1, -1), 1, "seen")
        return branch

    def _no_explanation(self) -> "GraphWriter":
        branch = type(self._writer)("unexplained/")
        nothing = branch.add("Identity", branch.constant(np.zeros((1, 0))))
        branch.add_output(nothing, 1, "seen")
        return branch

    def _decode(self, cls: str) -> None:
        """Add the autoregressive decoding of waypoints."""
        writer = self._writer
        red = writer.reshape(writer.add_input("red", np.float32, 1), 1, 1)
        state = writer.add("Concat", self._linear("narrow", cls), red, axis=1)
        state = writer.reshape(state, 1, 1, _STATE)
        goal = self._divided(writer.add_input("target", np.float32, 1, 2), (METRES,))
        point, points = writer.constant(np.zeros((1, 2))), []
        gates = self._gates()
        for _ in range(PLAN_STEPS):
            inputs = writer.reshape(writer.add("Concat", point, goal, axis=1), 1, 1, 4)
            state = writer.add_second(
                "GRU", inputs, *gates, "", state, hidden_size=_STATE, linear_before_reset=1
            )
            step = self._linear("step", writer.reshape(state, 1, _STATE))
            point = writer.add("Add", point, step)
            points.append(point)
        metres = writer.constant(np.array([METRES]))
        plan = writer.add("Mul", writer.add("Concat", *points, axis=0), metres)
        writer.reshape(plan, 1, PLAN_STEPS, 2, name=WAYPOINTS)

    def _gates(self) -> list[str]:
        """Return the GRU's weights for inputs and state, and its biases."""
        weights = [self._weights[f"decoder.{name}"] for name in _GRU_WEIGHTS]
        inputs, state, *biases = (_update_first(some) for some in weights)
        found = inputs[None], state[None], np.concatenate(biases)[None]
        return [self._writer.constant(some) for some in found]

    def _added(self, name: str, change: str, hidden: str) -> str:
        norm = self._constants(f"{name}.weight", f"{name}.bias")
        return self._writer.add(
            "SkipLayerNormalization", change, hidden, *norm, epsilon=NORM_EPSILON
        )

    def _linear(self, name: str, rows: str) -> str:
        weight, bias = self._weights[f"{name}.weight"], self._weights[f"{name}.bias"]
        return self._writer.linear(rows, weight, bias)

    def _in_layer(self, name: str, rows: str, part: slice = slice(None)) -> str:
        """Add a linear layer of the encoder, which takes nearly all of the time."""
        weight, bias = self._weights[f"{name}.weight"][part], self._weights[f"{name}.bias"][part]
        return self._in_layers(rows, weight, bias)

    def _divided(self, values: str, by: tuple[float, ...]) -> str:
        return self._writer.add("Div", values, self._writer.constant(np.array(by)))

    def _constants(self, *names: str) -> list[str]:
        return [self._writer.constant(self._weights[name]) for name in names]


_GRU_WEIGHTS = ("weight_ih", "weight_hh", "bias_ih", "bias_hh")


def _update_first(gates: np.ndarray) -> np.ndarray:
    """Reorder torch's gates (reset, update, new) for ONNX (update, reset, new)."""
    reset, update, new = np.split(gates, 3)
    return np.concatenate((update, reset, new))
