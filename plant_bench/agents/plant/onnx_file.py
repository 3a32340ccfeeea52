"""A graph's file, read with care: whole in itself, so that it never names another file to be read.

ONNX lets a tensor say that its values lie in another file, of any path. Such graphs are refused.
The file is searched as it is coded (protocol buffers), so that the package onnx is not needed.
"""

from collections.abc import Iterator
from pathlib import Path

from plant_bench.untrusted_files import check_file

LARGEST_GRAPH = 1_000_000_000  # bytes
_DEEPEST = 50  # graphs within nodes within graphs
_EXTERNAL_DATA, _DATA_LOCATION = 13, 14  # fields of a tensor
_VARINT, _EIGHT, _BYTES, _FOUR = 0, 1, 2, 5  # how a field is coded

_INSIDE: dict[str, dict[int, str]] = {  # messages that lead to tensors: field number to message
    "model": {7: "graph", 20: "training", 25: "function"},
    "training": {1: "graph", 2: "graph"},
    "function": {7: "node", 11: "attribute"},
    "graph": {1: "node", 5: "tensor", 15: "sparse"},
    "node": {5: "attribute"},
    "attribute": {5: "tensor", 6: "graph", 10: "tensor", 11: "graph", 22: "sparse", 23: "sparse"},
    "sparse": {1: "tensor", 2: "tensor"},
}


def read_graph(path: Path) -> bytes:
    """Return the bytes of a graph that is whole in itself.

    Raises:
        OSError: It cannot be read.
        ValueError: It is no graph, or has values in another file.
    """
    check_file(path, largest=LARGEST_GRAPH)
    content = path.read_bytes()
    _search(memoryview(content), "model", 0)
    return content


def _search(content: memoryview, message: str, depth: int) -> None:
    if depth > _DEEPEST:
        fault = "it is nested too deeply"
        raise ValueError(fault)
    for number, value in _fields(content):
        if message == "tensor":
            if number == _EXTERNAL_DATA or (number == _DATA_LOCATION and value != 0):
                fault = "it has values in another file, which are not read"
                raise ValueError(fault)
        elif (inner := _INSIDE[message].get(number)) is not None:
            if not isinstance(value, memoryview):
                fault = "it is no ONNX graph"
                raise ValueError(fault)
            _search(value, inner, depth + 1)


def _fields(content: memoryview) -> Iterator[tuple[int, memoryview | int]]:
    """Give number and value of each field of a message."""
    place = 0
    while place < len(content):
        tag, place = _varint(content, place)
        kind = tag & 7
        if kind == _VARINT:
            value, place = _varint(content, place)
        elif kind in {_BYTES, _EIGHT, _FOUR}:
            length = {_EIGHT: 8, _FOUR: 4}.get(kind, 0)
            if kind == _BYTES:
                length, place = _varint(content, place)
            if place + length > len(content):
                fault = "it is cut short"
                raise ValueError(fault)
            value, place = content[place : place + length], place + length
        else:
            fault = "it is no ONNX graph"
            raise ValueError(fault)
        yield tag >> 3, value


def _varint(content: memoryview, place: int) -> tuple[int, int]:
    """Return a whole number of 1 to 10 bytes, and the place behind it."""
    value = 0
    for count, byte in enumerate(content[place : place + 10]):
        value |= (byte & 0x7F) << (7 * count)
        if byte < 0x80:
            return value, place + count + 1
    fault = "it is cut short"
    raise ValueError(fault)
