"""A recording: every scene and action of one episode, in one Parquet file.

It has one row per tick. Equal episodes give equal bytes: the file contains no wall-clock times and
nothing about the machine. Values are stored exactly, so rescoring gives the same result.

A thinned recording, as written by `plant-bench collect`, has the ego at every tick, but actors and
lights only at every n-th: their columns are null in between. It also has a column for ticks with a
perturbed control.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa

from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.data.recording_file import ACTOR_COLUMNS, EGO_COLUMNS, REASON_COLUMNS, read_table
from plant_bench.data.tick_log import Action
from plant_bench.errors import InputError, in_one_line
from plant_bench.world.scene import Actors, EgoState, Scene


class Recording:
    """The scenes of one episode, in order.

    A thinned recording has scenes only for the rows in `complete_rows`.

    Attributes:
        metadata: The metadata passed to the recorder.
        egos: The ego at each tick, thinned or not; columns as `EGO_COLUMNS`.
        complete_rows: Rows with actors and lights: all rows, or those left by thinning.
        disturbed: For each row, whether another action than the agent's was executed.

    Args:
        table: The table that `Recorder` writes.
        metadata: The metadata, as above.
    """

    def __init__(self, table: pa.Table, metadata: dict[str, object]) -> None:
        self.metadata = metadata
        self._ticks = table["tick"].to_pylist()
        self._egos = list(zip(*(table[name].to_pylist() for name in EGO_COLUMNS), strict=True))
        self.egos = np.array(self._egos, float).reshape(-1, len(EGO_COLUMNS))
        present = table["actor_id"].is_valid().to_numpy()
        self.complete_rows: list[int] = np.flatnonzero(present).tolist()
        self._thinned = len(self.complete_rows) < len(self._ticks)
        thinned = "disturbed" in table.column_names
        self.disturbed = table["disturbed"].to_numpy() if thinned else np.zeros(len(present), bool)
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
            InputError: It does not exist, is broken or has another format.
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
        if self._thinned and not self._present[row]:
            message = (
                f"Tick {self._ticks[row]} of a thinned recording has no actors, so it cannot be "
                "rescored or replayed. Use the rows in `complete_rows`, and `egos` for the ego."
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
        """The agent's action at each scene."""
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
        """The agent's reasons; None if it made no decision or does not explain itself."""
        if not self._reasons:
            return [None] * len(self)
        causes, actors = (column.to_pylist() for column in self._reasons)
        return [
            None if cause is None else Reason(Cause(cause), actor)
            for cause, actor in zip(causes, actors, strict=True)
        ]


def _flat(column: pa.ChunkedArray) -> tuple[list[int], np.ndarray]:
    """Return the start index of each row in the values of a list column, and the values."""
    lists = column.combine_chunks()
    return lists.offsets.to_pylist(), lists.values.to_numpy(zero_copy_only=False)
