"""Builds an ONNX graph node by node, with the fused operators of ONNX Runtime."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import onnx
from jaxtyping import Float, UInt8
from onnx import TensorProto, helper, numpy_helper

OPSET = 17
IR_VERSION = 8  # the lowest for this opset, so that older runtimes can read it
MIN_HALF_SIZE = 256  # values in a constant from which it may be stored in half precision
FUSED = "com.microsoft"  # the domain of ONNX Runtime's own operators
FUSED_KINDS = frozenset({"Gelu", "MatMulNBits", "MultiHeadAttention", "SkipLayerNormalization"})
BLOCK = 32  # weights of an output that share a scale
MAX_VALUE = 127  # of an 8-bit weight, before ZERO_POINT is added
ZERO_POINT = 128  # of MatMulNBits
INTEGER_SUMS = 4  # accuracy level of MatMulNBits at which inputs, too, are quantised to 8 bits


class QuantisedWeights(NamedTuple):
    """Weights in 8 bits, in blocks along a layer's inputs.

    Attributes:
        values: Quantised weights plus `ZERO_POINT`.
        scales: The step size of each block.
    """

    values: UInt8[np.ndarray, "outputs blocks inside"]
    scales: Float[np.ndarray, "outputs blocks"]


def quantise(weight: Float[np.ndarray, "outputs inputs"]) -> QuantisedWeights:
    """Return weights in 8 bits; each block is scaled to its largest absolute weight.

    >>> values, scales = quantise(np.array([[2.54, -1.0] * 16], np.float32))
    >>> values[0, 0, :2].tolist(), round(float(scales[0, 0]), 4)
    ([255, 78], 0.02)
    """
    blocks = weight.reshape(len(weight), -1, BLOCK).astype(np.float32)
    scales = np.abs(blocks).max(axis=-1) / MAX_VALUE
    steps = np.where(scales == 0.0, 1.0, scales)[..., None]  # blocks of zeros
    values = np.round(blocks / steps) + ZERO_POINT
    return QuantisedWeights(values.astype(np.uint8), scales)


class GraphWriter:
    """Collects inputs, constants and nodes; all values are referred to by name; mutable.

    Args:
        prefix: Prefix of all generated names; a branch needs another one than its graph.
    """

    def __init__(self, prefix: str = "") -> None:
        self._prefix = prefix
        self._nodes: list[onnx.NodeProto] = []
        self._casts: list[onnx.NodeProto] = []
        self._constants: list[onnx.TensorProto] = []
        self._inputs: list[onnx.ValueInfoProto] = []
        self._outputs: list[onnx.ValueInfoProto] = []

    def add_input(self, name: str, kind: type[np.generic], *shape: int | str) -> str:
        """Declare an input and return its name; a text in the shape is a variable size."""
        self._inputs.append(helper.make_tensor_value_info(name, _code(kind), shape))
        return name

    def add_output(self, name: str, *shape: int | str) -> None:
        """Declare a value as a float32 output."""
        self._outputs.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, shape))

    def constant(self, values: np.ndarray) -> str:
        """Return the name of a constant, float32 or int64.

        Large float constants are stored in half precision, and cast when the graph is loaded, if
        that is lossless. This holds for weights saved in half precision and halves the file.
        """
        if np.issubdtype(values.dtype, np.integer):
            return self._stored(values.astype(np.int64))
        full = np.ascontiguousarray(values, np.float32)
        half = full.astype(np.float16)
        if full.size < MIN_HALF_SIZE or not np.array_equal(half.astype(np.float32), full):
            return self._stored(full)
        short = self._stored(half)
        name = f"{short}/full"
        self._casts.append(helper.make_node("Cast", [short], [name], to=TensorProto.FLOAT))
        return name

    def add(self, kind: str, *inputs: str, name: str | None = None, **attributes: Any) -> str:
        """Add a node and return its output's name."""
        return self._add(kind, inputs, [name or self._next()], attributes)

    def add_second(self, kind: str, *inputs: str, **attributes: Any) -> str:
        """Add a node with two outputs and return the second one's name; the first is omitted."""
        return self._add(kind, inputs, ["", self._next()], attributes)

    def linear(
        self,
        rows: str,
        weight: Float[np.ndarray, "outputs inputs"],
        bias: Float[np.ndarray, " outputs"],
    ) -> str:
        """Add a linear layer on rows, in float32."""
        return self.add("Gemm", rows, self.constant(weight.T), self.constant(bias))

    def quantised_linear(
        self,
        rows: str,
        weight: Float[np.ndarray, "outputs inputs"],
        bias: Float[np.ndarray, " outputs"],
    ) -> str:
        """Add a linear layer on rows, in 8 bits; `BLOCK` must divide its number of inputs."""
        values, scales = quantise(weight)
        stored = self._stored(values), self._stored(scales)
        outputs, inputs = weight.shape
        return self.add(
            "MatMulNBits",
            rows,
            *stored,
            "",  # zero point: the default, ZERO_POINT
            "",
            self.constant(bias),
            K=inputs,
            N=outputs,
            bits=8,
            block_size=BLOCK,
            accuracy_level=INTEGER_SUMS,
        )

    def reshape(self, value: str, *shape: int, name: str | None = None) -> str:
        """Add a reshape; -1 is the inferred size."""
        return self.add("Reshape", value, self.constant(np.array(shape)), name=name)

    def rows(self, value: str, start: int, stop: int) -> str:
        """Add a slice along the first axis."""
        ends = (self.constant(np.array([end])) for end in (start, stop, 0))
        return self.add("Slice", value, *ends)

    def cast(self, value: str, kind: type[np.generic]) -> str:
        """Add a cast to another dtype."""
        return self.add("Cast", value, to=_code(kind))

    def add_if(
        self, condition: str, then: "GraphWriter", otherwise: "GraphWriter", name: str
    ) -> str:
        """Add a conditional of two branches with one output each; they may use outer values.

        Only the chosen branch is computed; without it, a session computes all outputs.
        """
        branches = {"then_branch": then._graph(), "else_branch": otherwise._graph()}
        return self.add("If", condition, name=name, **branches)

    def write(self, path: Path) -> None:
        """Write the graph."""
        graph = self._graph()
        opsets = [helper.make_opsetid("", OPSET), helper.make_opsetid(FUSED, 1)]
        onnx.save(helper.make_model(graph, opset_imports=opsets, ir_version=IR_VERSION), path)

    def _graph(self) -> onnx.GraphProto:
        nodes = [*self._casts, *self._nodes]
        name = f"{self._prefix}graph"
        return helper.make_graph(nodes, name, self._inputs, self._outputs, self._constants)

    def _stored(self, values: np.ndarray) -> str:
        name = f"{self._prefix}constant{len(self._constants)}"
        self._constants.append(numpy_helper.from_array(values, name))
        return name

    def _next(self) -> str:
        return f"{self._prefix}value{len(self._nodes)}"

    def _add(
        self, kind: str, inputs: tuple[str, ...], outputs: list[str], attributes: dict[str, Any]
    ) -> str:
        domain = FUSED if kind in FUSED_KINDS else ""
        name = f"{kind}{len(self._nodes)}"
        node = helper.make_node(kind, inputs, outputs, name=name, domain=domain, **attributes)
        self._nodes.append(node)
        return outputs[-1]


def _code(kind: type[np.generic]) -> int:
    return helper.np_dtype_to_tensor_dtype(np.dtype(kind))
