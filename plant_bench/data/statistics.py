"""Statistics of a folder of collected data, and a check that all of its files can be read."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
from pydantic import BaseModel, ConfigDict

from plant_bench.data.completeness import impossible_motion
from plant_bench.data.recording import Recording
from plant_bench.data.recording_file import read_table
from plant_bench.errors import InputError, in_one_line
from plant_bench.world.route import Route, load_suite

STATIONARY_SPEED = 0.1  # m/s below which the ego is stationary (as in CARLA's blocked rule)
NEARBY = 30.0  # m: D_max of PlanT
SPEED_STEP, SPEED_BINS = 5.0, 16  # km/h; the last bin is open
MOST_NEARBY = 40  # actors; the last bin is open
FRAME = 0.5  # s between two frames: 2 Hz
_COLUMNS = ("x", "y", "speed", "actor_x", "actor_y")


class DataStatistics(BaseModel):
    """Statistics of the data.

    Attributes:
        episodes: Number of episodes.
        frames: Number of samples at 2 Hz.
        hours: Hours driven.
        km: Kilometres driven.
        standing_share: Share of frames in which the ego is stationary.
        speeds: Frames per bin of `SPEED_STEP` km/h; the last bin is open.
        nearby: Frames by number of actors within `NEARBY` metres; the last bin is open.
        nearby_mean: Mean number of actors within `NEARBY` metres.
        turns: Number of each manoeuvre driven.
        hazards: Number of hazards triggered, by kind.
        towns: Frames in each town.
        routes: Frames on each kind of route.
        disturbed_episodes: Number of episodes with perturbations.
        disturbed_share: Share of frames during a perturbation.
        megabytes: Size of all recordings.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    episodes: int
    frames: int
    hours: float
    km: float
    standing_share: float
    speeds: tuple[int, ...]
    nearby: tuple[int, ...]
    nearby_mean: float
    turns: dict[str, int]
    hazards: dict[str, int]
    towns: dict[str, int]
    routes: dict[str, int]
    disturbed_episodes: int
    disturbed_share: float
    megabytes: float


class _Hazard(BaseModel):
    kind: str
    phase: str


class _Metadata(BaseModel):
    """The metadata of a recording that the statistics use."""

    route: str
    town: str
    hazards: tuple[_Hazard, ...] = ()


@dataclass(frozen=True, eq=False)
class _Episode:
    metadata: _Metadata
    km: float
    speeds: np.ndarray  # m/s of each frame
    nearby: np.ndarray  # actors of each frame
    disturbed: np.ndarray  # bool of each frame


def route_kind(route_id: str) -> str:
    """Return the kind of route from a training route's id; "other" for other ids.

    >>> route_kind("town01-b-left_signal-3")
    'left_signal'
    """
    parts = route_id.rsplit("-", 2)
    return parts[1] if len(parts) == 3 else "other"


def episode_files(folder: Path) -> list[Path]:
    """Return the recordings of a data folder, sorted by name.

    Raises:
        InputError: There are none.
    """
    files = sorted((folder / "episodes").glob("*.parquet"))
    if not files:
        message = (
            f"There is no data in {folder}: expected a folder written by `plant-bench collect "
            "--out`, with recordings in episodes/*.parquet and their routes in routes/*.json."
        )
        raise InputError(message)
    return files


def data_routes(folder: Path) -> dict[str, Route]:
    """Return the routes of a data folder by id.

    Raises:
        InputError: They are missing or broken.
    """
    path = folder / "routes"
    if not path.is_dir():
        message = f"{folder} has no folder 'routes': expected the episodes' routes there."
        raise InputError(message)
    return {route.id: route for route in load_suite(str(path))}


def describe_data(folder: Path) -> DataStatistics:
    """Compute the statistics of a data folder.

    Raises:
        InputError: It is empty, or one of its files is broken.
    """
    files, routes = episode_files(folder), data_routes(folder)
    turns, hazards, towns, kinds = (Counter[str]() for _ in range(4))
    speeds, nearby = np.zeros(SPEED_BINS, int), np.zeros(MOST_NEARBY + 1, int)
    frames = standing = near = disturbed = perturbed = 0
    km = 0.0
    for episode in map(_read, files):
        name, count = episode.metadata.route, len(episode.speeds)
        if name not in routes:
            message = f"{folder}: the route {name} of an episode is missing in routes/*.json."
            raise InputError(message)
        frames, km = frames + count, km + episode.km
        bins = (episode.speeds * 3.6 / SPEED_STEP).clip(0, SPEED_BINS - 1).astype(int)
        speeds += np.bincount(bins, minlength=SPEED_BINS)
        nearby += np.bincount(episode.nearby.clip(max=MOST_NEARBY), minlength=MOST_NEARBY + 1)
        standing += int((episode.speeds < STATIONARY_SPEED).sum())
        near += int(episode.nearby.sum())
        disturbed += int(episode.disturbed.sum())
        perturbed += int(episode.disturbed.any())
        turns.update(routes[name].manoeuvres)
        hazards.update(item.kind for item in episode.metadata.hazards if item.phase == "done")
        towns[episode.metadata.town] += count
        kinds[route_kind(name)] += count
    return DataStatistics(
        episodes=len(files),
        frames=frames,
        hours=round(frames * FRAME / 3600.0, 3),
        km=round(km, 3),
        standing_share=round(standing / max(frames, 1), 4),
        speeds=tuple(speeds.tolist()),
        nearby=tuple(nearby.tolist()),
        nearby_mean=round(near / max(frames, 1), 3),
        turns=_sorted(turns),
        hazards=_sorted(hazards),
        towns=dict(sorted(towns.items())),
        routes=_sorted(kinds),
        disturbed_episodes=perturbed,
        disturbed_share=round(disturbed / max(frames, 1), 4),
        megabytes=round(sum(path.stat().st_size for path in files) / 1e6, 3),
    )


def find_data_faults(folder: Path) -> list[str]:
    """Read every file of a data folder completely, and return the problems found.

    Raises:
        InputError: It is empty, or its routes cannot be read.
    """
    files, routes = episode_files(folder), data_routes(folder)
    return [fault for path in files for fault in _faults(path, routes)]


def _faults(path: Path, routes: dict[str, Route]) -> Iterator[str]:
    try:
        recording = Recording.load(path)
        if motion := impossible_motion(recording.egos):
            yield f"{path}: {motion}, which is impossible."
        name = str(recording.metadata.get("route"))
        if name not in routes:
            yield f"{path}: its route {name} is missing in routes/*.json."
        else:
            _ = routes[name].town_dir  # raises InputError if the town is missing
        if not recording.complete_rows:
            yield f"{path}: it has no frames."
    except InputError as error:
        yield str(error)


def _read(path: Path) -> _Episode:
    """Read the columns of an episode that the statistics use."""
    try:
        table, metadata = read_table(path)
        marks = "disturbed" in table.column_names
        path_driven = np.hypot(np.diff(table["x"].to_numpy()), np.diff(table["y"].to_numpy()))
        marked = table["disturbed"].to_numpy() if marks else np.zeros(len(table), bool)
        complete = table["actor_x"].is_valid().to_numpy()
        return _Episode(
            _Metadata.model_validate(metadata),
            float(path_driven.sum()) / 1000.0,
            table["speed"].to_numpy()[complete],
            _nearby(table.filter(pa.array(complete))),
            marked[complete],
        )
    except (OSError, pa.ArrowException, KeyError, ValueError) as error:
        message = (
            f"Not a recording: {path} ({in_one_line(error)}). Remove it, and run the same "
            "`plant-bench collect` command again: it drives missing episodes."
        )
        raise InputError(message) from error


def _nearby(frames: pa.Table) -> np.ndarray:
    """Return the number of actors within `NEARBY` metres in each frame."""
    lists = {axis: frames[f"actor_{axis}"].combine_chunks() for axis in ("x", "y")}
    rows = np.repeat(np.arange(len(frames)), lists["x"].value_lengths().to_numpy())
    away = [
        values.flatten().to_numpy() - frames[axis].to_numpy()[rows]
        for axis, values in lists.items()
    ]
    return np.bincount(rows[np.hypot(*away) <= NEARBY], minlength=len(frames))


def _sorted(counts: Counter[str]) -> dict[str, int]:
    """Return the counts above zero, the most frequent first."""
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return {name: number for name, number in ordered if number}
