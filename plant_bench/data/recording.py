"""A recording: every scene and action of one episode, in one Parquet file.

One row a tick. Equal episodes give equal bytes: nothing of the clock or the machine is in the file.
What is read is what was recorded, bit for bit, so that the referee comes to the same verdict.

A thinned recording, as `plant-bench collect` writes them, has the ego at every tick and all others
at every n-th alone: their columns are null between. It also says at which ticks the control was
disturbed.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.data.recording_file import FORMAT_KEY, METADATA_KEY, read_table
from plant_bench.errors import InputError, in_one_line
from plant_bench.whole_files import whole_file
from plant_bench.world.scene import Actors, EgoState, Scene

RECORDING_FORMAT = 2
THINNED_FORMAT = 3
COMPRESSION_LEVEL = 3  # of zstd
EGO_COLUMNS = ("x", "y", "yaw", "speed", "acceleration", "steering")  # the fields of EgoState
ACTOR_COLUMNS = ("x", "y", "yaw", "speed", "length", "width")
REASON_COLUMNS = ("reason", "reason_actor")  # a `Cause`, and an actor's id

Action = Plan | Control | None


class Recorder:
    """Collects the ticks of one episode and writes them on `close`; mutable.

    A tick costs next to nothing, since scenes are immutable: they are kept as they are until then.

    Args:
        path: Where to write, for instance `episode.parquet`.
        metadata: What is known of the episode before it starts, as JSON-able values.
        every: Keep actors and lights at every so many ticks alone; more than 1 thins the recording.
    """

    def __init__(self, path: Path, metadata: Mapping[str, object], *, every: int = 1) -> None:
        self._path = path
        self._every = every
        self._metadata = dict(metadata)
        self._scenes: list[Scene] = []
        self._actions: list[Action] = []
        self._reasons: list[Reason | None] = []
        self._disturbed: list[bool] = []

    def add(
        self,
        scene: Scene,
        action: Action = None,
        reason: Reason | None = None,
        *,
        disturbed: bool = False,
    ) -> None:
        """Keep a scene, what the agent answered to it and why; None where it was not asked.

        Args:
            scene: To keep.
            action: What the agent answered.
            reason: Why.
            disturbed: Something else than the answer was executed; thinned recordings keep it.
        """
        if self._every > 1 and scene.tick % self._every:
            scene = Scene(scene.tick, scene.ego, Actors.none(), scene.lights[:0])
        self._scenes.append(scene)
        self._actions.append(action)
        self._reasons.append(reason)
        self._disturbed.append(disturbed)

    def close(self, **outcome: object) -> None:
        """Write the file, whole or not at all.

        Args:
            outcome: More metadata, known only at the end: why the agent crashed.
        """
        table = _table(self._scenes, self._actions, self._reasons)
        number = RECORDING_FORMAT
        if self._every > 1:
            number, table = THINNED_FORMAT, self._thinned(table)
        table = table.replace_schema_metadata(
            {
                FORMAT_KEY: str(number),
                METADATA_KEY: json.dumps(self._metadata | outcome, sort_keys=True),
            }
        )
        with whole_file(self._path) as part:
            pq.write_table(
                table,
                part,
                compression="zstd",
                compression_level=COMPRESSION_LEVEL,
                use_dictionary=False,
                use_byte_stream_split=_float_columns(table.schema),  # pyright: ignore[reportArgumentType]
                write_statistics=False,
            )

    def _thinned(self, table: pa.Table) -> pa.Table:
        """Put null where nothing was kept, and tell when the control was disturbed."""
        absent = pa.array([scene.tick % self._every != 0 for scene in self._scenes], pa.bool_())
        for place, name in enumerate(table.column_names):
            if name.startswith("actor_") or name == "lights":
                lists = table[name].combine_chunks()
                offsets, values = lists.offsets, lists.values
                hollow = pa.ListArray.from_arrays(offsets, values, mask=absent)
                table = table.set_column(place, name, hollow)
        return table.append_column("disturbed", pa.array(self._disturbed, pa.bool_()))


class Recording:
    """The scenes of one episode, in order.

    Of a thinned recording, only the scenes of `whole` can be had.

    Attributes:
        metadata: What the recorder was given.
        egos: The ego at each tick, thinned or not; columns as `EGO_COLUMNS`.
        whole: The rows whose scenes are whole: all of them, or those left by thinning.
        disturbed: Whether something else than the agent's answer was executed, for each row.

    Args:
        table: As `Recorder` writes it.
        metadata: As above.
    """

    def __init__(self, table: pa.Table, metadata: dict[str, object]) -> None:
        self.metadata = metadata
        self._ticks = table["tick"].to_pylist()
        self._egos = list(zip(*(table[name].to_pylist() for name in EGO_COLUMNS), strict=True))
        self.egos = np.array(self._egos, float).reshape(-1, len(EGO_COLUMNS))
        present = table["actor_id"].is_valid().to_numpy()
        self.whole: list[int] = np.flatnonzero(present).tolist()
        self._hollow = len(self.whole) < len(self._ticks)
        told = "disturbed" in table.column_names
        self.disturbed = table["disturbed"].to_numpy() if told else np.zeros(len(present), bool)
        self._present = present
        self._starts, ids = _flat(table["actor_id"])
        floats = {name: _flat(table[f"actor_{name}"])[1] for name in ACTOR_COLUMNS}
        self._actors = Actors(
            ids,
            np.stack([floats[name] for name in ("x", "y", "yaw")], axis=1),
            floats["speed"],
            np.stack([floats[name] for name in ("length", "width")], axis=1),
            _flat(table["actor_kind"])[1],
        )
        self._light_starts, self._lights = _flat(table["lights"])
        self._controls = (table["acceleration_asked"], table["steering_asked"])
        self._plans = table["plan"]
        self._reasons = [table[name] for name in REASON_COLUMNS if name in table.column_names]

    @classmethod
    def load(cls, path: Path) -> "Recording":
        """Read a recording.

        Raises:
            InputError: There is none, or it is broken or of another format.
        """
        try:
            return cls(*read_table(path))
        except (OSError, pa.ArrowException, KeyError, ValueError) as error:
            message = (
                f"Not a recording: {path} ({in_one_line(error)}). Remove it, and drive the episode "
                "again."
            )
            raise InputError(message) from error

    def __len__(self) -> int:
        return len(self._ticks)

    def __getitem__(self, row: int) -> Scene:
        row = range(len(self))[row]
        if self._hollow and not self._present[row]:
            message = (
                f"Tick {self._ticks[row]} of a thinned recording has no actors: use the rows in "
                "`whole`, and `egos` for the ego between. It cannot be scored again or replayed."
            )
            raise InputError(message)
        actors = self._actors
        part = slice(self._starts[row], self._starts[row + 1])
        return Scene(
            self._ticks[row],
            EgoState(*self._egos[row]),
            Actors(
                actors.ids[part],
                actors.poses[part],
                actors.speeds[part],
                actors.extents[part],
                actors.kinds[part],
            ),
            self._lights[self._light_starts[row] : self._light_starts[row + 1]],
        )

    def __iter__(self) -> Iterator[Scene]:
        return (self[row] for row in range(len(self)))

    @property
    def actions(self) -> list[Action]:
        """What the agent answered to each scene."""
        accelerations, steerings = (column.to_pylist() for column in self._controls)
        return [
            Plan(np.array(plan).reshape(-1, 2))
            if plan is not None
            else None
            if acceleration is None
            else Control(acceleration, steering)
            for plan, acceleration, steering in zip(
                self._plans.to_pylist(), accelerations, steerings, strict=True
            )
        ]

    @property
    def reasons(self) -> list[Reason | None]:
        """Why it answered so; None where it was not asked or does not explain itself."""
        if not self._reasons:
            return [None] * len(self)
        causes, actors = (column.to_pylist() for column in self._reasons)
        return [
            None if cause is None else Reason(Cause(cause), actor)
            for cause, actor in zip(causes, actors, strict=True)
        ]


def _table(scenes: list[Scene], actions: list[Action], reasons: list[Reason | None]) -> pa.Table:
    """Return the columns; float32 and the like are kept, anything wider is refused by numpy."""
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


def _flat(column: pa.ChunkedArray) -> tuple[list[int], np.ndarray]:
    """Return where each row starts in the values of a list column, and the values."""
    lists = column.combine_chunks()
    return lists.offsets.to_pylist(), lists.values.to_numpy(zero_copy_only=False)


def _float_columns(schema: pa.Schema) -> list[str]:
    """Return the names by which Parquet knows the columns of floats."""
    plain = [field.name for field in schema if pa.types.is_floating(field.type)]
    lists = [
        f"{field.name}.list.element"
        for field in schema
        if pa.types.is_list(field.type) and pa.types.is_floating(field.type.value_type)
    ]
    return plain + lists
