"""Compresses columns of numbers for replay pages: quantised, differenced, deflated, base64.

What moves steadily has second differences about 0, so a five-minute episode takes some 30 kB.
`web/src/replay/columns.js` reads it back.
"""

import base64
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

CENTI, MILLI = 100.0, 1000.0  # steps per metre, steps per radian
_MOST = 2**28  # second differences of larger values would not fit into 32 bits


@dataclass(frozen=True)
class Packed:
    """Compressed columns.

    Attributes:
        columns: Name, length, order of differences and bytes per value of each column, in order.
        data: All columns, deflated, in base64.
    """

    columns: list[list[str | int]]
    data: str


def quantised(values: np.ndarray, scale: float) -> np.ndarray:
    """Return values as integers in steps of 1/scale; values that are not finite become 0."""
    return np.round(np.nan_to_num(values, posinf=0.0, neginf=0.0) * scale).astype(np.int64)


def pack(columns: Mapping[str, tuple[np.ndarray, int]]) -> Packed:
    """Compress columns of integers.

    Args:
        columns: By name: the values, and the order of differences to store, 0 to 2.

    Raises:
        ValueError: A value is too large.
    """
    table: list[list[str | int]] = []
    parts: list[bytes] = []
    for name, (values, order) in columns.items():
        whole = np.asarray(values, np.int64)
        if whole.size and np.abs(whole).max() >= _MOST:
            message = f"Column {name}: expected values below {_MOST}, got {np.abs(whole).max()}."
            raise ValueError(message)
        for _ in range(order):
            whole = np.diff(whole, prepend=0)
        unsigned = ((whole << 1) ^ (whole >> 63)).astype("<u8")  # 0, -1, 1, -2 become 0, 1, 2, 3
        width = max(1, (int(unsigned.max(initial=0)).bit_length() + 7) // 8)
        planes = unsigned.view(np.uint8).reshape(-1, 8)[:, :width]
        parts.append(planes.T.tobytes())
        table.append([name, len(whole), order, width])
    deflated = zlib.compress(b"".join(parts), 9)
    return Packed(table, base64.b64encode(deflated).decode())
