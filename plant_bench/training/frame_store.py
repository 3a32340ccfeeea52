"""Caches the frames of data folders on disk; see `plant_bench.training.column_store`.

DIR/routes/*.json          the routes driven (suite files)
DIR/episodes/*.parquet     recordings; their metadata names the route
DIR/frames/<key>/          the frames; the key is a hash of the code that builds them
DIR/encoded/<key>/         the encodings of cached learners, see `encodings`
"""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Int

from plant_bench.data.completeness import impossible_motion, incompleteness
from plant_bench.data.recording import Recording
from plant_bench.data.statistics import episode_files
from plant_bench.errors import InputError
from plant_bench.learner import Frame
from plant_bench.runner.collect.data_folder import DataFolder
from plant_bench.training.code_keys import closure_hash
from plant_bench.training.column_store import (
    ColumnStore,
    EpisodeBuilder,
    ProgressCallback,
    open_packs,
    start_offsets,
)
from plant_bench.training.frames import (
    OF_ACTORS,
    Rows,
    TargetKind,
    frame_of,
    no_action_message,
    rows_of,
)
from plant_bench.world.route import PROTOCOL, Route, load_suite

FRAMES_FORMAT = 1
KEY_LENGTH = 12
STATIONARY_SPEED, STATIONARY_DISTANCE = 0.1, 0.2  # m/s; metres ahead in the next two seconds
FIRST, LAST = 0, -1


@dataclass(frozen=True, eq=False)
class Episodes:
    """The episodes of one pack of frames.

    Attributes:
        data: The data folder.
        pack: The frames' columns, see `plant_bench.training.frames`.
    """

    data: Path
    pack: ColumnStore

    @cached_property
    def first_frames(self) -> Int[np.ndarray, " ends"]:
        """First frame row of each episode in the pack, and the end."""
        return start_offsets(np.array([episode.rows["at"] for episode in self.pack.episodes]))

    @cached_property
    def first_instants(self) -> Int[np.ndarray, " ends"]:
        """First instant row of each episode in the pack, and the end."""
        return start_offsets(np.array([episode.rows["tick"] for episode in self.pack.episodes]))

    @cached_property
    def first_actors(self) -> Int[np.ndarray, " ends"]:
        """First actor row of each instant, and the end."""
        return self._starts("actor_count", OF_ACTORS[0])

    @cached_property
    def first_lights(self) -> Int[np.ndarray, " ends"]:
        """First light row of each instant, and the end."""
        return self._starts("light_count", "lights")

    def _starts(self, counts: str, values: str) -> Int[np.ndarray, " ends"]:
        found = start_offsets(self.pack.columns[counts])
        if found[LAST] != len(self.pack.columns[values]):
            message = f"Broken pack: {self.pack.folder}. Remove it; it is rebuilt."
            raise InputError(message)
        return found

    def frame(self, number: int, row: int, *, targets: TargetKind, inputs: frozenset[str]) -> Frame:
        """Return a frame of episode `number` of the pack, by its row in the pack."""
        facts = self.pack.episodes[number].facts
        at = int(self.first_instants[number] + self.pack.columns["at"][row])
        place = (row, at, int(self.first_actors[at]), int(self.first_lights[at]))
        route = route_of(self.data / "routes", facts["route"], facts["checksum"])
        return frame_of(
            self.pack.columns, place, route, targets=targets, inputs=inputs, seed=facts["seed"]
        )


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames of several data folders, in the order of folders and recordings.

    Attributes:
        targets: Kind of the frames' waypoints.
        sources: The packs that hold the frames.
        source: Index in `sources` of each frame's pack.
        episode: Index of each frame's episode in its pack.
        row: Row of each frame in its pack.
        routes: Route id of each episode by (source, episode), in the order of the frames.
        fingerprint: Hash of everything that determines the frames.
    """

    targets: TargetKind
    sources: tuple[Episodes, ...]
    source: Int[np.ndarray, " frames"]
    episode: Int[np.ndarray, " frames"]
    row: Int[np.ndarray, " frames"]
    routes: dict[tuple[int, int], str]
    fingerprint: str

    def __len__(self) -> int:
        return len(self.row)

    def frame(self, number: int, inputs: frozenset[str]) -> Frame:
        """Return a frame whose observation has the given inputs."""
        source = self.sources[self.source[number]]
        episode, row = int(self.episode[number]), int(self.row[number])
        return source.frame(episode, row, targets=self.targets, inputs=inputs)

    def route_mask(self, names: frozenset[str]) -> Bool[np.ndarray, " frames"]:
        """Return a mask of the frames on the given routes."""
        selected = [place for place, name in self.routes.items() if name in names]
        most = 1 + max((episode for _, episode in self.routes), default=0)
        ids = np.array([source * most + episode for source, episode in selected], np.int64)
        return np.isin(self.source * most + self.episode, ids)

    def stationary(self, chosen: Int[np.ndarray, " chosen"]) -> Bool[np.ndarray, " chosen"]:
        """Return a mask of the chosen frames in which the ego is stationary and should stay so."""
        name = "future" if self.targets == "future" else "answered"
        found = np.zeros(len(chosen), bool)
        for number, source in enumerate(self.sources):
            mine = np.flatnonzero(self.source[chosen] == number)
            rows, episodes = self.row[chosen[mine]], self.episode[chosen[mine]]
            columns = source.pack.columns
            at = source.first_instants[episodes] + columns["at"][rows]
            speed = columns["ego"][at, 3].astype(np.float32)
            ahead = columns[name][rows, LAST, 0]
            found[mine] = (speed < STATIONARY_SPEED) & (np.abs(ahead) < STATIONARY_DISTANCE)
        return found


@dataclass(frozen=True)
class _Task:
    recording: Path
    routes: Path


@cache
def frames_key() -> str:
    """Return the name of the folder of frames: a hash of format, protocol and code."""
    code = closure_hash("plant_bench.training.frames")
    text = f"{FRAMES_FORMAT}|{PROTOCOL}|{code}"
    return hashlib.sha256(text.encode()).hexdigest()[:KEY_LENGTH]


def load_frames(
    folders: Sequence[Path],
    *,
    targets: TargetKind = "future",
    share: float = 1.0,
    workers: int = 1,
    on_progress: ProgressCallback | None = None,
) -> Frames:
    """Return the frames of data folders; converts the missing episodes.

    Args:
        folders: The data folders.
        targets: Kind of the waypoints. "future": the ego's driven path, as PlanT; frames with a
            perturbation in that path are dropped. "expert-action": the path along the route if the
            expert's acceleration is held; for data in which another planner drove (DAgger), too.
        share: Share of the recordings, see `recordings_in`.
        workers: Number of processes that convert.
        on_progress: Called with the number of finished episodes and their total number.

    Raises:
        InputError: A folder, a recording or its route cannot be used, or an expert action is
            missing.
    """
    builder = EpisodeBuilder(_build_episode, workers, on_progress)
    sources: list[Episodes] = []
    chosen: list[tuple[int, int, str]] = []
    for data in folders:
        names, packs = _episodes(data, targets, share, builder)
        places = {
            episode.name: (len(sources) + place, number)
            for place, pack in enumerate(packs)
            for number, episode in enumerate(pack.episodes)
        }
        sources += [Episodes(data, pack) for pack in packs]
        chosen += [(*places[name], name) for name in names]
    return _join(sources, chosen, targets)


def _episodes(
    data: Path, targets: TargetKind, share: float, builder: EpisodeBuilder
) -> tuple[list[str], list[ColumnStore]]:
    recordings = recordings_in(data, share)
    check_targets(data, targets)
    routes = data / "routes"
    if not any(routes.glob("*.json")):
        message = f"No routes found: expected the driven routes in {routes}/*.json."
        raise InputError(message)
    routes_in(routes)
    tasks = {f"{path.stem}-{_content_hash(path)}": _Task(path, routes) for path in recordings}
    return list(tasks), open_packs(data / "frames" / frames_key(), tasks, builder)


def _join(
    sources: list[Episodes], chosen: list[tuple[int, int, str]], targets: TargetKind
) -> Frames:
    columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    digest = hashlib.sha256(f"{frames_key()}|{targets}".encode())
    routes: dict[tuple[int, int], str] = {}
    for place, number, name in chosen:
        source = sources[place]
        rows = _target_rows(source, number, targets)
        columns.append((np.full(len(rows), place), np.full(len(rows), number), rows))
        routes[place, number] = source.pack.episodes[number].facts["route"]
        digest.update(f"|{name}|{routes[place, number]}".encode())
    source, episode, row = (
        np.concatenate([np.zeros(0, np.int64), *(item[axis] for item in columns)])
        for axis in range(3)
    )
    fingerprint = digest.hexdigest()[:16]
    return Frames(targets, tuple(sources), source, episode, row, routes, fingerprint)


def _target_rows(source: Episodes, number: int, targets: TargetKind) -> Int[np.ndarray, " rows"]:
    """Return the rows of an episode that have a valid target."""
    first, end = source.first_frames[number : number + 2].tolist()
    rows = np.arange(first, end)
    if targets == "future":
        return rows[~source.pack.columns["disturbed"][first:end]]
    missing = np.isnan(source.pack.columns["answered"][first:end, FIRST, FIRST])
    if missing.any():
        name = source.pack.episodes[number].facts["recording"]
        at = source.pack.columns["at"][first + int(missing.argmax())]
        tick = source.pack.columns["tick"][source.first_instants[number] + at]
        message = f"{source.data / 'episodes' / name}: {no_action_message(int(tick))}"
        raise InputError(message)
    return rows


def check_targets(data: Path, targets: TargetKind) -> None:
    """Check that a data folder has valid targets of a kind.

    Raises:
        InputError: The driven path was requested, but a planner other than the expert drove.
    """
    origin = DataFolder(data).origin()
    if origin is not None and origin.driver and targets == "future":
        message = (
            f"{data} was driven by '{origin.driver}' (DAgger data), so its driven path is no "
            "target. Train on the recorded actions of the expert: --targets expert-action."
        )
        raise InputError(message)


def check_completeness(data: Path) -> None:
    """Check that each episode of a data folder is there once.

    Raises:
        InputError: One is there twice, or missing.
    """
    if problems := incompleteness(data, episode_files(data)):
        raise InputError(" ".join(problems))


def recordings_in(data: Path, share: float = 1.0) -> list[Path]:
    """Return a share of the recordings of a data folder, sorted by name.

    First repetitions are taken before second ones, as in PlanT's 1x, 2x and 3x data; within a
    repetition the order is that of hashes of the names, so any share covers all towns. A smaller
    share is a subset of any larger one.

    Raises:
        InputError: There are no recordings.
    """
    found = episode_files(data)
    count = max(round(share * len(found)), 1)
    return sorted(sorted(found, key=_sort_key)[:count])


def _sort_key(recording: Path) -> tuple[int, bytes]:
    repetition = re.search(r"_r(\d+)_[0-9a-f]+$", recording.stem)
    digest = hashlib.sha256(recording.stem.encode()).digest()
    return (int(repetition[1]) if repetition else 0), digest


def _build_episode(task: _Task) -> tuple[Rows, dict[str, Any]]:
    recording = Recording.load(task.recording)
    name = str(recording.metadata.get("route"))
    route = routes_in(task.routes).get(name)
    if route is None:
        message = f"{task.recording} was driven on route '{name}', which is not in {task.routes}."
        raise InputError(message)
    if motion := impossible_motion(recording.egos):
        message = (
            f"{task.recording}: {motion}, which is impossible. Remove the file, and run the same "
            "`plant-bench collect` command again to replace it."
        )
        raise InputError(message)
    try:
        rows = rows_of(recording, route)
    except InputError as error:
        message = f"{task.recording}: {error}"
        raise InputError(message) from error
    seed = recording.metadata.get("seed", 0)
    return rows, {
        "recording": task.recording.name,
        "route": name,
        "checksum": route.checksum,
        "seed": seed if isinstance(seed, int) else 0,
    }


def route_of(folder: Path, name: str, checksum: str) -> Route:
    """Return a route from a folder.

    Raises:
        InputError: The route is missing, or has changed.
    """
    route = routes_in(folder).get(name)
    if route is None or route.checksum != checksum:
        message = f"Route {name} in {folder} is missing or has changed: restore the driven route."
        raise InputError(message)
    return route


@lru_cache(maxsize=64)
def routes_in(folder: Path) -> dict[str, Route]:
    """Return the routes in a folder by id; cached.

    Raises:
        InputError: They cannot be read.
    """
    return {route.id: route for route in load_suite(str(folder))}


@cache
def _content_hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:KEY_LENGTH]
