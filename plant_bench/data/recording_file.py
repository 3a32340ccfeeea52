"""Reads and validates a recording's Parquet file: columns, types, lengths and values.

The file is untrusted input. After these checks, reading its rows cannot fail.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from plant_bench.agent import Cause
from plant_bench.data.parquet_footer import value_counts
from plant_bench.untrusted_files import check_file, parse_json

RECORDING_FORMAT, THINNED_FORMAT = 2, 3
READABLE_FORMATS = (1, RECORDING_FORMAT, THINNED_FORMAT)  # 1 has no reasons
EGO_COLUMNS = ("x", "y", "yaw", "speed", "acceleration", "steering")  # the fields of EgoState
ACTOR_COLUMNS = ("x", "y", "yaw", "speed", "length", "width")
REASON_COLUMNS = ("reason", "reason_actor")  # a `Cause`, and an actor's id
FORMAT_KEY, METADATA_KEY = b"plant_bench.recording", b"plant_bench.metadata"
LARGEST_FILE = 200_000_000  # bytes; an episode has about 1 million
LARGEST_UNPACKED = 400_000_000  # bytes of all columns, uncompressed; an episode has about 7 million
MOST_VALUES = 100_000_000  # total of all columns
MOST_TICKS = 200_000  # nearly three hours; an episode times out long before

_EGO = dict.fromkeys(EGO_COLUMNS, pa.float64())
_REQUESTED = {
    "acceleration_asked": pa.float64(),
    "steering_asked": pa.float64(),
    "plan": pa.list_(pa.float64()),
}
_ACTORS = {
    "actor_id": pa.list_(pa.int64()),
    **{f"actor_{name}": pa.list_(pa.float32()) for name in ACTOR_COLUMNS},
    "actor_kind": pa.list_(pa.uint8()),
}
_LIGHTS = {"lights": pa.list_(pa.uint8())}
_REQUIRED = {"tick": pa.int32(), **_EGO, **_REQUESTED, **_ACTORS, **_LIGHTS}
_OPTIONAL = {"reason": pa.int8(), "reason_actor": pa.int64(), "disturbed": pa.bool_()}


def read_table(path: Path) -> tuple[pa.Table, dict[str, Any]]:
    """Read a recording's table and metadata.

    Raises:
        OSError: It cannot be read.
        ValueError: It is not a valid recording; includes Arrow's errors, which are subclasses.
    """
    check_file(path, largest=LARGEST_FILE)
    _check_counts(value_counts(path))
    with pq.ParquetFile(path) as file:
        _check_size(file.metadata)
        keys = file.schema_arrow.metadata or {}
        if keys.get(FORMAT_KEY) not in {str(number).encode() for number in READABLE_FORMATS}:
            message = f"expected format {' or '.join(map(str, READABLE_FORMATS))}"
            raise ValueError(message)
        _check_types(file.schema_arrow)
        metadata = parse_json(keys.get(METADATA_KEY, b"").decode())
        _fail_if(not isinstance(metadata, dict), "expected a JSON object as metadata")
        table = file.read(use_threads=False)
    table.validate(full=True)
    _check_ego(table)
    _check_actors(table)
    _check_actions(table)
    return table, metadata


def _check_size(facts: pq.FileMetaData) -> None:
    """Check the memory that reading would need, before decompressing anything."""
    groups = [facts.row_group(place) for place in range(facts.num_row_groups)]
    parts = [group.total_byte_size for group in groups]
    size = -1 if min(parts, default=0) < 0 else sum(parts)
    fits = facts.num_rows <= MOST_TICKS and 0 <= size <= LARGEST_UNPACKED
    _fail_if(not fits, f"too large: {facts.num_rows:,} ticks, {size:,} bytes")


def _check_counts(counts: list[int]) -> None:
    """Check the number of values, since a billion equal ones compress to a few bytes."""
    fits = min(counts, default=0) >= 0 and sum(counts) <= MOST_VALUES
    _fail_if(not fits, f"too large: {sum(counts):,} values")


def _check_types(schema: pa.Schema) -> None:
    found = {field.name: field.type for field in schema}
    _fail_if(len(found) < len(schema), "a column occurs twice")
    expected = _REQUIRED | {name: kind for name, kind in _OPTIONAL.items() if name in found}
    both = ("reason" in found) == ("reason_actor" in found)
    _fail_if(not both, "only one of the columns reason and reason_actor")
    for name, kind in expected.items():
        actual = found.get(name, pa.null())
        _fail_if(not actual.equals(kind), f"column {name}: expected {kind}, got {actual}")


def _check_ego(table: pa.Table) -> None:
    for name in ("tick", *_EGO, *(name for name in ("disturbed",) if name in table.column_names)):
        _fail_if(table[name].null_count, f"column {name} has null values")
    for name in _EGO:
        _fail_if(
            not np.isfinite(table[name].to_numpy()).all(),
            f"column {name} has values that are not finite",
        )
    ticks = np.diff(table["tick"].to_numpy().astype(np.int64))
    _fail_if((ticks <= 0).any(), "ticks are not ascending")


def _check_actors(table: pa.Table) -> None:
    """Check that all actor columns have equal lengths, and that lights are at the same ticks."""
    counts = table["actor_id"].combine_chunks().value_lengths()
    for name in (*_ACTORS, *_LIGHTS):
        inside = table[name].combine_chunks().flatten()
        _fail_if(inside.null_count, f"column {name} has null values")
        if name in _ACTORS:
            equal = table[name].combine_chunks().value_lengths().equals(counts)
            _fail_if(not equal, f"column {name} has other numbers of actors than actor_id")
        if pa.types.is_floating(inside.type):
            _fail_if(
                not np.isfinite(inside.to_numpy()).all(),
                f"column {name} has values that are not finite",
            )
    equal = table["lights"].is_valid().equals(table["actor_id"].is_valid())
    _fail_if(not equal, "lights and actors are at different ticks")


def _check_actions(table: pa.Table) -> None:
    one, other = (table[name].is_valid() for name in ("acceleration_asked", "steering_asked"))
    _fail_if(not one.equals(other), "a control without acceleration or without steering")
    numbers = table["plan"].combine_chunks().value_lengths().drop_null().to_numpy()
    _fail_if((numbers % 2 != 0).any(), "a plan with an odd number of coordinates")
    _fail_if(table["plan"].combine_chunks().flatten().null_count, "a plan with null values")
    if "reason" in table.column_names:
        causes = set(table["reason"].unique().drop_null().to_pylist())
        equal = table["reason"].is_valid().equals(table["reason_actor"].is_valid())
        _fail_if(not equal, "reason and reason_actor are at different ticks")
        _fail_if(causes - {int(cause) for cause in Cause}, "an unknown reason")


def _fail_if(fault: object, message: str) -> None:
    """Raise an error if a condition holds."""
    if fault:
        raise ValueError(message)
