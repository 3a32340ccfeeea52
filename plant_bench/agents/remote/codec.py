"""Encodes messages as msgpack, and arrays as raw little-endian bytes with shape and dtype."""

import re
from collections.abc import Mapping
from typing import Any

import msgpack
import numpy as np

from plant_bench.agents.remote.remote_errors import ProtocolError

FLOAT64 = np.dtype("<f8")
MOST_ITEMS = 100_000  # of one list or map in a message
MOST_AXES = 5  # of an array
MOST_PASSES = 1000  # forward passes in one response
_TYPE = re.compile(r"<(f[248]|[iu][248])|\|(b1|[iu]1)")


def pack(message: Mapping[str, Any]) -> bytes:
    """Return a message as bytes."""
    packed = msgpack.packb(message, use_bin_type=True)
    return bytes(packed or b"")  # packb returns None only for packers without autoreset


def unpack(data: bytes) -> dict[str, Any]:
    """Decode a message.

    Raises:
        ProtocolError: It is not a msgpack map with text keys, or is too large.
    """
    try:
        message = msgpack.unpackb(
            data,
            raw=False,
            strict_map_key=True,
            max_array_len=MOST_ITEMS,
            max_map_len=MOST_ITEMS,
            max_ext_len=0,
        )
    except (ValueError, msgpack.UnpackException, RecursionError, OverflowError) as error:
        wrong = "expected msgpack, got invalid data."
        raise ProtocolError(wrong) from error
    if not isinstance(message, dict) or not all(isinstance(key, str) for key in message):
        wrong = f"expected a map with text keys, got a {type(message).__name__}."
        raise ProtocolError(wrong)
    return message


def array_out(values: np.ndarray) -> dict[str, Any]:
    """Return the wire form of an array whose dtype the receiver knows: float64."""
    return {"shape": list(values.shape), "data": values.astype(FLOAT64, copy=False).tobytes()}


def typed_array_out(values: np.ndarray) -> dict[str, Any]:
    """Return the wire form of an array of any dtype, such as an image or point cloud."""
    kind = values.dtype.newbyteorder("<")
    data = values.astype(kind, copy=False).tobytes()
    return {"shape": list(values.shape), "data": data, "dtype": kind.str}


def array_in(wire: Any, kind: Any = None) -> np.ndarray:
    """Return a received array, read-only.

    Args:
        wire: The received value; float64 if it has no dtype.
        kind: The dtype to convert to; None to keep it.

    Raises:
        ProtocolError: It is not an array, or its shape and data do not match.
    """
    if not isinstance(wire, dict) or set(wire) - {"dtype"} != {"shape", "data"}:
        message = "expected an array: a map of shape and data."
        raise ProtocolError(message)
    shape, data, sent = wire["shape"], wire["data"], _type_of(wire.get("dtype", FLOAT64.str))
    if not _is_shape(shape) or not isinstance(data, bytes):
        message = f"expected an array's shape as a list of up to {MOST_AXES} sizes, data as bytes."
        raise ProtocolError(message)
    count = 1
    for size in shape:
        count *= size
    if len(data) != count * sent.itemsize:
        name = "little-endian float64" if sent == FLOAT64 else sent.name
        message = f"expected the data of an array of shape {tuple(shape)} as {count} {name}."
        raise ProtocolError(message)
    values = np.frombuffer(data, sent).reshape(shape)
    if kind is not None and values.dtype != kind:
        values = values.astype(kind)
        values.flags.writeable = False
    return values


def _type_of(name: Any) -> np.dtype:
    """Return the dtype of a name: numbers of 1 to 8 bytes, and booleans."""
    if not isinstance(name, str) or not _TYPE.fullmatch(name):
        message = "expected an array's dtype such as '<f4', '<i8' or '|u1'."
        raise ProtocolError(message)
    return np.dtype(name)


def _is_shape(shape: Any) -> bool:
    return (
        isinstance(shape, list)
        and len(shape) <= MOST_AXES
        and all(type(size) is int and 0 <= size < 1 << 31 for size in shape)
    )
