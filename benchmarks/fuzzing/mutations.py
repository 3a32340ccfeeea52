"""Mutations of files that are likely to cause errors."""

import json
import random
import struct
from collections.abc import Sequence
from typing import Any

import msgpack
import pyarrow as pa
import pyarrow.parquet as pq

from fuzzing.xml_mutations import xml_changed

EVIL: tuple[str, ...] = (  # JSON, as text: some of it is none
    "NaN", "Infinity", "-Infinity", "1e999", "-1e308", "1e-320", "0", "-1", "-0.0", "1",
    "9" * 400, "9" * 5000, str(2**31), str(2**63), str(-(2**63) - 1), "1.5", "null", "true",
    "false", '""', '"../../../etc/passwd"', '"/etc/passwd"', '"a\\u0000b"', '"\\ud800"', '"\\n"',
    '"' + "x" * 300 + '"', '"' + "y" * 100_000 + '"', "[]", "{}", "[[]]", '[null]', '{"a": 1}',
    "[" * 2000 + "]" * 2000, "[" * 100_000 + "]" * 100_000, "[" + "0," * 50_000 + "0]",
    '"file:///dev/zero"', '"$(touch x)"', '"__import__(\'os\').system(\'id\')"', '"lb1.0"',
    '"Completed"', '"town99"', "1000000000", '"nan"', "[1, 2]", '[["a", 0, 1]]',
)  # fmt: skip
EVIL_VALUES: tuple[Any, ...] = (  # of a message: msgpack has what JSON has not
    None, True, 0, -1, 2**63 - 1, -(2**63), 2**64 - 1, 1.5, float("nan"), float("inf"), "",
    "x" * 300, "x" * 20_000, "\x1b[31m\n", "\ud800", b"", b"\0" * 8, b"\xff" * 64, [], {}, [[]],
    {"shape": [0], "data": b""}, {"shape": [2**31, 2**31, 2**31], "data": b""}, {"shape": [-1]},
    {"shape": [4, 2], "data": b"\xff" * 64}, [0] * 2000, msgpack.ExtType(5, b"x"),
    msgpack.Timestamp(1), "hello", "ready", "control", "plan", "ranks",
)  # fmt: skip
_MARK = "\x01evil\x02"


def mutated(chance: random.Random, seeds: Sequence[bytes], kind: str) -> bytes:
    """Return a broken file.

    Args:
        chance: Draws how.
        seeds: Files that are whole.
        kind: As of `fuzzing.form.Format`; all but "bytes" are also changed by their structure.
    """
    content = chance.choice(seeds)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        way = chance.random()
        if kind == "json" and way < 0.7:
            content = _json_changed(chance, content)
        elif kind == "safetensors" and way < 0.6:
            content = _head_changed(chance, content)
        elif kind == "parquet" and way < 0.7:
            content = _table_changed(chance, content)
        elif kind == "xml" and way < 0.8:
            content = xml_changed(chance, content)
        elif kind == "msgpack" and way < 0.7:
            content = message_changed(chance, content)
        else:
            content = _bytes_changed(chance, content, chance.choice(seeds))
    return content


def _table_changed(chance: random.Random, content: bytes) -> bytes:
    """Change a column, or what is said of the whole, of a table that can still be read."""
    try:
        table = pq.read_table(pa.BufferReader(content), use_threads=False)
        name = chance.choice(table.column_names or [""])
    except (pa.ArrowException, OSError, ValueError, MemoryError):  # a name may be no text
        return content
    way = chance.randrange(7)
    try:
        if way == 0:
            table = table.drop_columns([name])
        elif way == 1:
            table = table.rename_columns(
                [chance.choice(("x", "", item)) for item in table.column_names]
            )
        elif way == 2:
            table = table.set_column(0, name, pa.nulls(len(table), table[name].type))
        elif way == 3:
            column = table[name].take(
                pa.array([chance.randrange(len(table)) for _ in range(len(table))])
            )
            table = table.set_column(table.column_names.index(name), name, column)
        elif way == 4:
            values = [_value(chance, item) for item in table[name].to_pylist()]
            column = pa.array(values, table[name].type)
            table = table.set_column(table.column_names.index(name), name, column)
        elif way == 5:
            metadata = dict(table.schema.metadata or {})
            key = chance.choice(list(metadata) or [b"x"])
            metadata[key] = _json_changed(chance, metadata.get(key, b"{}"))
            table = table.replace_schema_metadata(metadata)
        else:
            kind = chance.choice((pa.string(), pa.float32(), pa.int64(), pa.bool_(), pa.null()))
            column = pa.nulls(len(table), kind)
            table = table.set_column(table.column_names.index(name), name, column)
        sink = pa.BufferOutputStream()
        pq.write_table(table, sink)
    except (pa.ArrowException, ValueError, TypeError, OverflowError, KeyError, MemoryError):
        return content
    return sink.getvalue().to_pybytes()


def _value(chance: random.Random, value: Any) -> Any:
    """Return a value, now and then another one."""
    if isinstance(value, list):
        value = [_value(chance, item) for item in value]
        return value + value[:1] if chance.random() < 0.05 else value
    if chance.random() > 0.05:
        return value
    return chance.choice((None, 0, -1, 127, 1e30, float("nan"), float("inf"), True))


def _bytes_changed(chance: random.Random, content: bytes, other: bytes) -> bytes:
    place = chance.randrange(len(content) + 1)
    end = min(place + chance.choice((1, 2, 4, 8, 64, 1024)), len(content))
    way = chance.randrange(8)
    if way == 0:
        return content[:place]
    if way == 1:
        return content[:place] + content[end:]
    if way == 2:
        return content[:end] + content[place:end] * chance.choice((1, 2, 50)) + content[end:]
    if way == 3:
        return content[:place] + chance.randbytes(end - place) + content[end:]
    if way == 4 and content:
        changed = bytearray(content)
        for _ in range(chance.choice((1, 1, 2, 16))):
            changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
        return bytes(changed)
    if way == 5:
        number = chance.choice((0, -1, 2**31 - 1, -(2**31), 2**63 - 1, 255, 65536))
        return content[:place] + struct.pack("<q", number) + content[place + 8 :]
    if way == 6:
        return content[:place] + other[chance.randrange(len(other) + 1) :]
    tail = len(content) - chance.randrange(min(len(content), 3000) + 1)  # where indexes lie
    return content[:tail] + bytes([chance.randrange(256)]) + content[tail + 1 :]


def _json_changed(chance: random.Random, content: bytes) -> bytes:
    try:
        value = json.loads(content)
    except (ValueError, RecursionError):
        return content
    evil = chance.choice(EVIL)
    lock_owner, key = _place(chance, value)
    if lock_owner is None:
        return evil.encode()
    way = chance.randrange(6)
    if way == 0:
        del lock_owner[key]
    elif way == 1 and isinstance(lock_owner, dict):
        lock_owner[chance.choice(("extra", "", "__class__", "../x", key + " "))] = _MARK
    elif way == 2 and isinstance(lock_owner, list):
        lock_owner.insert(key, lock_owner[key])
    elif way == 3 and isinstance(lock_owner[key], str):
        lock_owner[key] = lock_owner[key] + chance.choice(("/../..", "\0", " ", "é", "x" * 300))
    else:
        lock_owner[key] = _MARK
    try:
        return json.dumps(value).replace(json.dumps(_MARK), evil).encode()
    except (ValueError, RecursionError):
        return content


def message_changed(chance: random.Random, content: bytes) -> bytes:
    """Change the values of a msgpack message, which follows its length in four bytes."""
    try:
        value = msgpack.unpackb(content[4:], strict_map_key=False, unicode_errors="surrogatepass")
        lock_owner, key = _place(chance, value)
        if lock_owner is None:
            return content
        evil, way = chance.choice(EVIL_VALUES), chance.randrange(4)
        if way == 0:
            del lock_owner[key]
        elif way == 1 and isinstance(lock_owner, dict):
            lock_owner[chance.choice(("extra", "", 5, b"x", "type", "shape"))] = evil
        else:
            lock_owner[key] = evil
        packed = bytes(msgpack.packb(value, unicode_errors="surrogatepass") or b"")
    except (ValueError, TypeError, OverflowError, RecursionError, msgpack.UnpackException):
        return content
    return struct.pack("<I", len(packed)) + packed


def _place(chance: random.Random, value: Any) -> tuple[Any, Any]:
    """Return a lock_owner and one of its keys, shallow ones as likely as deep ones."""
    lock_owner, key = None, None
    while isinstance(value, dict | list) and value:
        lock_owner = value
        key = (
            chance.choice(list(value)) if isinstance(value, dict) else chance.randrange(len(value))
        )
        value = value[key]
        if chance.random() < 0.3:
            break
    return lock_owner, key


def _head_changed(chance: random.Random, content: bytes) -> bytes:
    """Change the JSON that a safetensors file begins with."""
    if len(content) < 8:
        return content
    (length,) = struct.unpack("<Q", content[:8])
    if length > len(content):
        return content
    head = _json_changed(chance, content[8 : 8 + length])
    told = len(head) if chance.random() < 0.9 else chance.choice((0, 2**63, len(head) + 8))
    return struct.pack("<Q", told) + head + content[8 + length :]
