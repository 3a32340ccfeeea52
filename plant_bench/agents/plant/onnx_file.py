"""Reads an ONNX file safely: refuses graphs that load tensors from other files.

ONNX lets a tensor refer to its values in another file, at any path. The check parses the protocol
buffers itself, so that the package onnx is not needed.
"""

from collections.abc import Iterator
from pathlib import Path

from plant_bench.untrusted_files import check_file

LARGEST_GRAPH = 1_000_000_000  # bytes
_MAX_DEPTH = 50  # of nested messages
_EXTERNAL_DATA, _DATA_LOCATION = 13, 14  # fields of a tensor
_VARINT, _EIGHT, _BYTES, _FOUR = 0, 1, 2, 5  # wire types

_FIELDS: dict[str, dict[int, str]] = {  # messages that contain tensors: field number to message
    "model": {7: "graph", 20: "training", 25: "function"},
    "training": {1: "graph", 2: "graph"},
    "function": {7: "node", 11: "attribute"},
    "graph": {1: "node", 5: "tensor", 15: "sparse"},
    "node": {5: "attribute"},
    "attribute": {5: "tensor", 6: "graph", 10: "tensor", 11: "graph", 22: "sparse", 23: "sparse"},
    "sparse": {1: "tensor", 2: "tensor"},
}


def read_graph(path: Path) -> bytes:
    """Return the bytes of a self-contained graph.

    Raises:
        OSError: It cannot be read.
        ValueError: It is not an ONNX graph, or refers to another file.
    """
    check_file(path, largest=LARGEST_GRAPH)
    content = path.read_bytes()
    _search(memoryview(content), "model", 0)
    return content


def _search(content: memoryview, message: str, depth: int) -> None:
    if depth > _MAX_DEPTH:
        fault = "it is nested too deeply"
        raise ValueError(fault)
    for number, value in _fields(content):
        if message == "tensor":
            if number == _EXTERNAL_DATA or (number == _DATA_LOCATION and value != 0):
                fault = "it has values in another file, which is not allowed"
                raise ValueError(fault)
        elif (inner := _FIELDS[message].get(number)) is not None:
            if not isinstance(value, memoryview):
                fault = "it is not an ONNX graph"
                raise ValueError(fault)
            _search(value, inner, depth + 1)


def _fields(content: memoryview) -> Iterator[tuple[int, memoryview | int]]:
    """Yield the number and value of each field of a message."""
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
                fault = "it is truncated"
                raise ValueError(fault)
            value, place = content[place : place + length], place + length
        else:
            fault = "it is not an ONNX graph"
            raise ValueError(fault)
        yield tag >> 3, value


def _varint(content: memoryview, place: int) -> tuple[int, int]:
    """Return an integer of 1 to 10 bytes, and the position after it."""
    value = 0
    for count, byte in enumerate(content[place : place + 10]):
        value |= (byte & 0x7F) << (7 * count)
        if byte < 0x80:
            return value, place + count + 1
    fault = "it is truncated"
    raise ValueError(fault)
