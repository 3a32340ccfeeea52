"""Puts together a graph in ONNX, node by node, with the fused operators of ONNX Runtime."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import onnx
from jaxtyping import Float, UInt8
from onnx import TensorProto, helper, numpy_helper

OPSET = 17
IR_VERSION = 8  # the first for this opset: older runtimes read it, too
LEAST_HALVED = 256  # values of a constant from which on it is stored in half precision
FUSED = "com.microsoft"  # the domain of operators that ONNX Runtime adds to ONNX's
FUSED_KINDS = frozenset({"Gelu", "MatMulNBits", "MultiHeadAttention", "SkipLayerNormalization"})
BLOCK = 32  # weights of an output that share a scale
HIGHEST = 127  # of a weight in 8 bits, stored with MIDDLE added
MIDDLE = 128  # the operator's zero
INTEGER_SUMS = 4  # the operator's level of accuracy at which inputs are rounded to 8 bits, too


class Rounded(NamedTuple):
    """Weights in 8 bits, in blocks along a layer's inputs.

    Attributes:
        values: With `MIDDLE` added.
        scales: What a step of the values is worth.
    """

    values: UInt8[np.ndarray, "outputs blocks inside"]
    scales: Float[np.ndarray, "outputs blocks"]


def rounded(weight: Float[np.ndarray, "outputs inputs"]) -> Rounded:
    """Return weights in 8 bits, each block with the scale that its largest weight needs.

    >>> values, scales = rounded(np.array([[2.54, -1.0] * 16], np.float32))
    >>> values[0, 0, :2].tolist(), round(float(scales[0, 0]), 4)
    ([255, 78], 0.02)
    """
    blocks = weight.reshape(len(weight), -1, BLOCK).astype(np.float32)
    scales = np.abs(blocks).max(axis=-1) / HIGHEST
    steps = np.where(scales == 0.0, 1.0, scales)[..., None]  # a block of nothing but 0
    values = np.round(blocks / steps) + MIDDLE
    return Rounded(values.astype(np.uint8), scales)


class GraphWriter:
    """Collects inputs, constants and nodes, and knows every value by its name; mutable.

    Args:
        prefix: Of all names it gives; that of a branch must differ from that of its graph.
    """

    def __init__(self, prefix: str = "") -> None:
        self._prefix = prefix
        self._nodes: list[onnx.NodeProto] = []
        self._casts: list[onnx.NodeProto] = []
        self._constants: list[onnx.TensorProto] = []
        self._inputs: list[onnx.ValueInfoProto] = []
        self._outputs: list[onnx.ValueInfoProto] = []

    def takes(self, name: str, kind: type[np.generic], *shape: int | str) -> str:
        """Declare an input, a free size given by a name; return its name."""
        self._inputs.append(helper.make_tensor_value_info(name, _code(kind), shape))
        return name

    def gives(self, name: str, *shape: int | str) -> None:
        """Declare a value an output, of float32."""
        self._outputs.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, shape))

    def constant(self, values: np.ndarray) -> str:
        """Return the name of a constant, float32 or int64.

        Many floats are stored in half precision where nothing is lost by it, and cast when the
        graph is loaded: half the file. So it is with weights that were stored in half precision.
        """
        if np.issubdtype(values.dtype, np.integer):
            return self._stored(values.astype(np.int64))
        full = np.ascontiguousarray(values, np.float32)
        half = full.astype(np.float16)
        if full.size < LEAST_HALVED or not np.array_equal(half.astype(np.float32), full):
            return self._stored(full)
        short = self._stored(half)
        name = f"{short}/full"
        self._casts.append(helper.make_node("Cast", [short], [name], to=TensorProto.FLOAT))
        return name

    def add(self, kind: str, *inputs: str, name: str | None = None, **attributes: Any) -> str:
        """Add a node and return the name of what it gives."""
        return self._add(kind, inputs, [name or self._next()], attributes)

    def add_last(self, kind: str, *inputs: str, **attributes: Any) -> str:
        """Add a node of two outputs of which only the second is wanted; return its name."""
        return self._add(kind, inputs, ["", self._next()], attributes)

    def linear(
        self,
        rows: str,
        weight: Float[np.ndarray, "outputs inputs"],
        bias: Float[np.ndarray, " outputs"],
    ) -> str:
        """Add a linear layer of two axes in float32."""
        return self.add("Gemm", rows, self.constant(weight.T), self.constant(bias))

    def rounded_linear(
        self,
        rows: str,
        weight: Float[np.ndarray, "outputs inputs"],
        bias: Float[np.ndarray, " outputs"],
    ) -> str:
        """Add a linear layer of two axes with weights of 8 bits; `BLOCK` must divide its inputs."""
        values, scales = rounded(weight)
        stored = self._stored(values), self._stored(scales)
        outputs, inputs = weight.shape
        return self.add(
            "MatMulNBits",
            rows,
            *stored,
            "",  # the zero is MIDDLE
            "",
            self.constant(bias),
            K=inputs,
            N=outputs,
            bits=8,
            block_size=BLOCK,
            accuracy_level=INTEGER_SUMS,
        )

    def reshape(self, value: str, *shape: int, name: str | None = None) -> str:
        """Add another shape; -1 stands for what is left."""
        return self.add("Reshape", value, self.constant(np.array(shape)), name=name)

    def rows(self, value: str, start: int, stop: int) -> str:
        """Add the choice of rows, the first axis."""
        ends = (self.constant(np.array([end])) for end in (start, stop, 0))
        return self.add("Slice", value, *ends)

    def cast(self, value: str, kind: type[np.generic]) -> str:
        """Add another type."""
        return self.add("Cast", value, to=_code(kind))

    def add_choice(
        self, condition: str, then: "GraphWriter", otherwise: "GraphWriter", name: str
    ) -> str:
        """Add two branches of one output each, which may use the values of this graph.

        Only one is computed: what is asked of a session does not decide what it computes.
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
