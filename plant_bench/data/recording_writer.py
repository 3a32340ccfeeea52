"""Writes a recording: converts the recorded ticks to the columns of a Parquet file."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from plant_bench.agent import Control, Plan, Reason
from plant_bench.atomic_files import whole_file
from plant_bench.data.recording_file import (
    ACTOR_COLUMNS,
    EGO_COLUMNS,
    FORMAT_KEY,
    METADATA_KEY,
    RECORDING_FORMAT,
    THINNED_FORMAT,
)
from plant_bench.data.tick_log import Action, Ticks
from plant_bench.world.scene import Scene

COMPRESSION_LEVEL = 3  # of zstd


def write_recording(path: Path, ticks: Ticks, metadata: Mapping[str, object]) -> None:
    """Write a recording atomically.

    Args:
        path: Path of the file.
        ticks: The recorded ticks.
        metadata: The episode's metadata, as JSON values.
    """
    table = _table(ticks.scenes, ticks.actions, ticks.reasons)
    number = RECORDING_FORMAT
    if ticks.every > 1:
        number, table = THINNED_FORMAT, _thinned(table, ticks)
    table = table.replace_schema_metadata(
        {FORMAT_KEY: str(number), METADATA_KEY: json.dumps(metadata, sort_keys=True)}
    )
    with whole_file(path) as part:
        pq.write_table(
            table,
            part,
            compression="zstd",
            compression_level=COMPRESSION_LEVEL,
            use_dictionary=False,
            use_byte_stream_split=_float_columns(table.schema),  # pyright: ignore[reportArgumentType]
            write_statistics=False,
        )


def _thinned(table: pa.Table, ticks: Ticks) -> pa.Table:
    """Set actors and lights to null in skipped ticks, and add the column of disturbed ticks."""
    absent = pa.array([scene.tick % ticks.every != 0 for scene in ticks.scenes], pa.bool_())
    for place, name in enumerate(table.column_names):
        if name.startswith("actor_") or name == "lights":
            lists = table[name].combine_chunks()
            offsets, values = lists.offsets, lists.values
            hollow = pa.ListArray.from_arrays(offsets, values, mask=absent)
            table = table.set_column(place, name, hollow)
    return table.append_column("disturbed", pa.array(ticks.disturbed, pa.bool_()))


def _table(scenes: list[Scene], actions: list[Action], reasons: list[Reason | None]) -> pa.Table:
    """Return the columns as a table; an array of a wider type than its column raises TypeError."""
    columns: dict[str, pa.Array] = {"tick": pa.array([scene.tick for scene in scenes], pa.int32())}
    for name in EGO_COLUMNS:
        columns[name] = pa.array(
            [float(getattr(scene.ego, name)) for scene in scenes], pa.float64()
        )
    actors = [scene.actors for scene in scenes]
    starts = _starts([len(item) for item in actors])
    poses = _joined([item.poses for item in actors], (0, 3), np.float32)
    extents = _joined([item.extents for item in actors], (0, 2), np.float32)
    speeds = _joined([item.speeds for item in actors], (0,), np.float32)
    columns["actor_id"] = _lists(starts, _joined([item.ids for item in actors], (0,), np.int64))
    for name, values in zip(ACTOR_COLUMNS, (*poses.T, speeds, *extents.T), strict=True):
        columns[f"actor_{name}"] = _lists(starts, np.ascontiguousarray(values))
    columns["actor_kind"] = _lists(starts, _joined([item.kinds for item in actors], (0,), np.uint8))
    columns["lights"] = _lists(
        _starts([len(scene.lights) for scene in scenes]),
        _joined([scene.lights for scene in scenes], (0,), np.uint8),
    )
    return pa.table(columns | _action_columns(actions) | _reason_columns(reasons))


def _action_columns(actions: list[Action]) -> dict[str, pa.Array]:
    controls = [action if isinstance(action, Control) else None for action in actions]
    plans = [action.waypoints if isinstance(action, Plan) else None for action in actions]
    return {
        "acceleration_asked": pa.array(
            [control and float(control.acceleration) for control in controls], pa.float64()
        ),
        "steering_asked": pa.array(
            [control and float(control.steering) for control in controls], pa.float64()
        ),
        "plan": pa.array(
            [plan if plan is None else plan.astype(float).reshape(-1) for plan in plans],
            pa.list_(pa.float64()),
        ),
    }


def _reason_columns(reasons: list[Reason | None]) -> dict[str, pa.Array]:
    return {
        "reason": pa.array([reason and int(reason.cause) for reason in reasons], pa.int8()),
        "reason_actor": pa.array([reason and reason.actor for reason in reasons], pa.int64()),
    }


def _joined(parts: list[np.ndarray], empty: tuple[int, ...], kind: type) -> np.ndarray:
    return np.concatenate([np.zeros(empty, kind), *parts], dtype=kind, casting="safe")


def _starts(counts: list[int]) -> np.ndarray:
    return np.concatenate(([0], np.cumsum(counts, dtype=np.int32))).astype(np.int32)


def _lists(starts: np.ndarray, values: np.ndarray) -> pa.ListArray:
    return pa.ListArray.from_arrays(pa.array(starts), pa.array(values))


def _float_columns(schema: pa.Schema) -> list[str]:
    """Return the Parquet names of the float columns."""
    plain = [field.name for field in schema if pa.types.is_floating(field.type)]
    lists = [
        f"{field.name}.list.element"
        for field in schema
        if pa.types.is_list(field.type) and pa.types.is_floating(field.type.value_type)
    ]
    return plain + lists
