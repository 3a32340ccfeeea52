"""Values as bytes: msgpack, and arrays as raw little-endian numbers with their shape and type."""

import re
from collections.abc import Mapping
from typing import Any

import msgpack
import numpy as np

from plant_bench.agents.remote.remote_errors import ProtocolError

FLOAT64 = np.dtype("<f8")
MOST_ITEMS = 100_000  # of one list or map in a message
MOST_AXES = 5  # of an array
MOST_PASSES = 1000  # forward passes told in one answer
_TYPE = re.compile(r"<(f[248]|[iu][248])|\|(b1|[iu]1)")


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
    """Return an array as it is sent where its type is known: as float64."""
    return {"shape": list(values.shape), "data": values.astype(FLOAT64, copy=False).tobytes()}


def typed_array_out(values: np.ndarray) -> dict[str, Any]:
    """Return an array as it is sent where it may be of any type: images, point clouds."""
    kind = values.dtype.newbyteorder("<")
    data = values.astype(kind, copy=False).tobytes()
    return {"shape": list(values.shape), "data": data, "dtype": kind.str}


def array_in(wire: Any, kind: Any = None) -> np.ndarray:
    """Return the array that was sent, which cannot be written to.

    Args:
        wire: What was sent; float64 where it does not say its type.
        kind: The type wanted; None for the one it came in.

    Raises:
        ProtocolError: It is none, or its shape and its bytes do not agree.
    """
    if not isinstance(wire, dict) or set(wire) - {"dtype"} != {"shape", "data"}:
        message = "an array is wanted: a map of shape and data."
        raise ProtocolError(message)
    shape, data, sent = wire["shape"], wire["data"], _type_of(wire.get("dtype", FLOAT64.str))
    if not _is_shape(shape) or not isinstance(data, bytes):
        message = f"an array is wanted as a list of at most {MOST_AXES} sizes, and bytes."
        raise ProtocolError(message)
    count = 1
    for size in shape:
        count *= size
    if len(data) != count * sent.itemsize:
        name = "little-endian float64" if sent == FLOAT64 else sent.name
        message = f"an array of shape {tuple(shape)} is wanted as {count} {name}."
        raise ProtocolError(message)
    values = np.frombuffer(data, sent).reshape(shape)
    if kind is not None and values.dtype != kind:
        values = values.astype(kind)
        values.flags.writeable = False
    return values


def _type_of(name: Any) -> np.dtype:
    """Return the type that a text names: numbers of 1 to 8 bytes, and truth values."""
    if not isinstance(name, str) or not _TYPE.fullmatch(name):
        message = "an array's dtype is wanted as in '<f4', '<i8' or '|u1'."
        raise ProtocolError(message)
    return np.dtype(name)


def _is_shape(shape: Any) -> bool:
    return (
        isinstance(shape, list)
        and len(shape) <= MOST_AXES
        and all(type(size) is int and 0 <= size < 1 << 31 for size in shape)
    )
