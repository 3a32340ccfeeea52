"""Parses the footer of a Parquet file in Python, since Arrow aborts on some malformed files.

The footer is a struct in Thrift's compact protocol; structs are parsed to dicts by field number.
"""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

LONGEST_FOOTER = 4_000_000  # bytes; that of a recording has about 10 thousand
DEEPEST = 16  # maximum nesting of structs and lists
MAGIC = b"PAR1"
_ROW_GROUPS, _COLUMNS, _COLUMN, _NUM_VALUES = 4, 1, 3, 5  # field numbers in parquet.thrift


def value_counts(path: Path) -> list[int]:
    """Return the number of values of each column of each row group, as stated in the footer.

    Raises:
        OSError: It cannot be read.
        ValueError: It is not a Parquet file, or its footer is broken or too long.
    """
    try:
        groups = _Reader(_footer(path)).struct()[_ROW_GROUPS]
        counts = [column[_COLUMN][_NUM_VALUES] for group in groups for column in group[_COLUMNS]]
        if any(type(count) is not int for count in counts):
            raise TypeError
    except (IndexError, KeyError, TypeError, struct.error) as error:
        message = "the Parquet footer is broken"
        raise ValueError(message) from error
    return counts


def _footer(path: Path) -> bytes:
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(size - 8, 0))
        length, magic = struct.unpack("<I4s", file.read(8))
        if magic != MAGIC or length > min(size - 8, LONGEST_FOOTER):
            message = "it has no Parquet footer"
            raise ValueError(message)
        file.seek(size - 8 - length)
        return file.read(length)


class _Reader:
    """Reads values of Thrift's compact protocol one after the other; mutable."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at, self._depth = data, 0, 0
        self._readers: dict[int, Callable[[], Any]] = {
            1: lambda: True,
            2: lambda: False,
            3: self._byte,
            4: self._signed_varint,
            5: self._signed_varint,
            6: self._signed_varint,
            7: lambda: self._take(8),
            8: lambda: self._take(self._varint()),
            9: self._list,
            10: self._list,
            12: self.struct,
        }  # 11 (map) does not occur in Parquet's schema

    def struct(self) -> dict[int, Any]:
        """Parse a struct; return its values by field number."""
        self._go_deeper()
        found: dict[int, Any] = {}
        number = 0
        while head := self._byte():
            number = _short(number + (head >> 4) if head >> 4 else self._signed_varint())
            found[number] = self._readers[head & 15]()
        self._depth -= 1
        return found

    def _list(self) -> list[Any]:
        self._go_deeper()
        head = self._byte()
        count = self._varint() if head >> 4 == 15 else head >> 4
        read = self._byte if head & 15 in (1, 2) else self._readers[head & 15]
        if count > len(self._data) - self._at:  # each item takes at least a byte
            raise IndexError
        found = [read() for _ in range(count)]
        self._depth -= 1
        return found

    def _go_deeper(self) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise IndexError

    def _byte(self) -> int:
        self._at += 1
        return self._data[self._at - 1]

    def _take(self, length: int) -> bytes:
        self._at += length
        if self._at > len(self._data):
            raise IndexError
        return self._data[self._at - length : self._at]

    def _varint(self) -> int:
        value = 0
        for shift in range(0, 70, 7):
            byte = self._byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value & (2**64 - 1)
        raise IndexError

    def _signed_varint(self) -> int:
        value = self._varint()
        return (value >> 1) ^ -(value & 1)


def _short(number: int) -> int:
    """Wrap a field number to a signed 16-bit integer, as Thrift's own readers do."""
    return (number + 2**15) % 2**16 - 2**15
