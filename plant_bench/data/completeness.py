"""Checks of collected data as a whole: episodes that occur twice, are missing or are impossible."""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float

from plant_bench.data.recording_file import LARGEST_FILE, METADATA_KEY
from plant_bench.untrusted_files import check_file, parse_json, read_json
from plant_bench.world.scene import TICK

FASTEST = 100.0  # m/s; the limit on the fastest roads is less than half of that
TOLERANCE = 1.0  # m between two ticks, beyond the distance at the ego's speed
_SPEED = 3  # column of the ego's speed
_AGAIN = "run the same `plant-bench collect` command again: it drives missing episodes."


def incompleteness(folder: Path, files: Sequence[Path]) -> list[str]:
    """Return what is wrong with the episodes of a data folder as a set, one sentence per problem.

    Args:
        folder: Folder of the data.
        files: Its recordings.
    """
    return [
        *(_twice(folder, len(files), same) for same in _doubled(files)),
        *_missing(folder, {path.stem for path in files}),
    ]


def impossible_motion(egos: Float[np.ndarray, "ticks columns"]) -> str:
    """Return why an ego's motion is impossible; empty if it is not.

    Args:
        egos: The ego at each tick, as `Recording.egos`.

    >>> impossible_motion(np.array([[0.0, 0.0, 0.0, 10.0], [0.5, 0.0, 0.0, 10.0]]))
    ''
    >>> impossible_motion(np.array([[0.0, 0.0, 0.0, 10.0], [500.0, 0.0, 0.0, 10.0]]))
    'the ego jumps by 500 m at 0.05 s, at a speed of 10 m/s'
    """
    speeds = np.abs(egos[:, _SPEED])
    if speeds.size and speeds.max() > FASTEST:
        at = int(speeds.argmax())
        return f"the ego drives at {speeds[at]:.0f} m/s at {at * TICK:.2f} s"
    steps = np.hypot(np.diff(egos[:, 0]), np.diff(egos[:, 1]))
    fastest = np.maximum(speeds[:-1], speeds[1:])
    excess = steps - fastest * TICK
    if excess.size and excess.max() > TOLERANCE:
        at = int(excess.argmax())
        return (
            f"the ego jumps by {steps[at]:.0f} m at {(at + 1) * TICK:.2f} s, at a speed of "
            f"{fastest[at]:.0f} m/s"
        )
    return ""


def _doubled(files: Sequence[Path]) -> list[list[Path]]:
    """Return the groups of recordings that are of the same episode."""
    groups: dict[str, list[Path]] = defaultdict(list)
    for path in files:
        if scenario := _scenario(path):
            groups[scenario].append(path)
    return [sorted(same) for same in groups.values() if len(same) > 1]


def _scenario(path: Path) -> str:
    """Return the scenario of a recording; empty if it is unknown, or the file is broken."""
    try:
        check_file(path, largest=LARGEST_FILE)
        keys = pq.read_schema(path).metadata or {}
        metadata = parse_json(keys.get(METADATA_KEY, b"").decode())
        return str(metadata.get("scenario", "")) if isinstance(metadata, dict) else ""
    except (OSError, ValueError, pa.ArrowException):
        return ""


def _twice(folder: Path, count: int, same: Sequence[Path]) -> str:
    names = " and ".join(path.name for path in same)
    number = "two" if len(same) == 2 else str(len(same))
    return (
        f"{folder}: {count} recordings, of which {number} are of the same episode: {names}. Keep "
        "one of them."
    )


def _missing(folder: Path, present: set[str]) -> list[str]:
    told = {path.stem for path in (folder / "records").glob("*.json") if _is_kept(path)}
    missing = sorted(told - present)
    if missing:
        count, which = len(told), ", ".join(missing[:3]) + (", ..." if len(missing) > 3 else "")
        text = f"{count} episodes that records/ and data.json tell of {_are(missing)} missing"
        return [f"{folder}: {len(missing)} of {text}: {which}. Copy the rest, or {_AGAIN}"]
    count = 0 if told else _count_in_summary(folder)
    if len(present) < count:
        absent = range(count - len(present))
        text = f"{count} episodes that data.json tells of {_are(absent)} missing"
        return [f"{folder}: {len(absent)} of {text}. Copy the rest, or {_AGAIN}"]
    return []


def _are(things: Sequence[object]) -> str:
    return "is" if len(things) == 1 else "are"


def _is_kept(record: Path) -> bool:
    """Whether the episode of a record is part of the data; not if the record is broken."""
    try:
        return read_json(record)["left_out"] == ""
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _count_in_summary(folder: Path) -> int:
    try:
        return int(read_json(folder / "data.json")["data"]["episodes"])
    except (OSError, ValueError, KeyError, TypeError, OverflowError):
        return 0
