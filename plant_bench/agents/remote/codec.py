"""Values as bytes: msgpack, and arrays as raw little-endian float64 with their shape."""

from collections.abc import Mapping
from typing import Any

import msgpack
import numpy as np

from plant_bench.agents.remote.failures import ProtocolError

FLOAT64 = np.dtype("<f8")
MOST_ITEMS = 100_000  # of one list or map in a message
MOST_AXES = 3  # of an array
MOST_PASSES = 1000  # forward passes told in one answer


def pack(message: Mapping[str, Any]) -> bytes:
    """Return a message as bytes."""
    packed = msgpack.packb(message, use_bin_type=True)
    return bytes(packed or b"")  # never None: that is for packers that keep what they pack


def unpack(data: bytes) -> dict[str, Any]:
    """Return the message that bytes hold.

    Raises:
        ProtocolError: They are no msgpack map with text keys, or hold too much.
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
        wrong = "it sent what is no msgpack."
        raise ProtocolError(wrong) from error
    if not isinstance(message, dict) or not all(isinstance(key, str) for key in message):
        wrong = f"it sent a {type(message).__name__}: a map with text keys is wanted."
        raise ProtocolError(wrong)
    return message


def array_out(values: np.ndarray) -> dict[str, Any]:
    """Return an array as it is sent."""
    return {"shape": list(values.shape), "data": values.astype(FLOAT64, copy=False).tobytes()}


def array_in(wire: Any) -> np.ndarray:
    """Return the float64 array that was sent; it cannot be written to.

    Raises:
        ProtocolError: It is none, or its shape and its bytes do not agree.
    """
    if not isinstance(wire, dict) or set(wire) != {"shape", "data"}:
        message = "an array is wanted: a map of shape and data."
        raise ProtocolError(message)
    shape, data = wire["shape"], wire["data"]
    if not _is_shape(shape) or not isinstance(data, bytes):
        message = f"an array is wanted as a list of at most {MOST_AXES} sizes, and bytes."
        raise ProtocolError(message)
    count = 1
    for size in shape:
        count *= size
    if len(data) != count * FLOAT64.itemsize:
        message = f"an array of shape {tuple(shape)} is wanted as {count} little-endian float64."
        raise ProtocolError(message)
    return np.frombuffer(data, FLOAT64).reshape(shape)


def _is_shape(shape: Any) -> bool:
    return (
        isinstance(shape, list)
        and len(shape) <= MOST_AXES
        and all(type(size) is int and 0 <= size < 1 << 31 for size in shape)
    )
