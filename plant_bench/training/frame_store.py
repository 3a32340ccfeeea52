"""Caches the frames of data folders on disk; see `plant_bench.training.column_store`.

DIR/routes/*.json          the routes driven (suite files)
DIR/episodes/*.parquet     recordings; their metadata names the route
DIR/frames/<key>/          the frames; the key is a hash of the code that makes them
DIR/encoded/<key>/         what cached learners make of them, see `encodings`
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

from plant_bench.data.recording import Recording
from plant_bench.data.statistics import episode_files
from plant_bench.errors import InputError
from plant_bench.learner import Frame
from plant_bench.runner.collect.data_folder import DataFolder
from plant_bench.training.code_keys import closure_hash
from plant_bench.training.column_store import ColumnStore, Making, Progress, open_packs, starts_of
from plant_bench.training.frames import (
    OF_ACTORS,
    Rows,
    TargetKind,
    frame_of,
    no_answer,
    rows_of,
)
from plant_bench.world.route import PROTOCOL, Route, load_suite

FRAMES_FORMAT = 1
KEY_LENGTH = 12
STANDING, STAYING = 0.1, 0.2  # m/s, and metres in two seconds
FIRST, LAST = 0, -1


@dataclass(frozen=True, eq=False)
class Episodes:
    """Episodes of one pack that are learned from.

    Attributes:
        data: The data folder.
        pack: Of their frames.
        number: Which of the pack's episodes each is.
    """

    data: Path
    pack: ColumnStore

    @cached_property
    def first_frames(self) -> Int[np.ndarray, " ends"]:
        """Where the frames of each of the pack's episodes start."""
        return starts_of(np.array([episode.rows["at"] for episode in self.pack.episodes]))

    @cached_property
    def first_instants(self) -> Int[np.ndarray, " ends"]:
        """Where the instants of each of the pack's episodes start."""
        return starts_of(np.array([episode.rows["tick"] for episode in self.pack.episodes]))

    @cached_property
    def first_actors(self) -> Int[np.ndarray, " ends"]:
        """Where the actors of each instant start."""
        return self._starts("actor_count", OF_ACTORS[0])

    @cached_property
    def first_lights(self) -> Int[np.ndarray, " ends"]:
        """Where the lights of each instant start."""
        return self._starts("light_count", "lights")

    def _starts(self, counts: str, values: str) -> Int[np.ndarray, " ends"]:
        found = starts_of(self.pack.columns[counts])
        if found[LAST] != len(self.pack.columns[values]):
            message = f"Broken pack: {self.pack.folder}. Remove it; it is made again."
            raise InputError(message)
        return found

    def frame(self, number: int, row: int, *, targets: TargetKind, inputs: frozenset[str]) -> Frame:
        """Return a frame of an episode, by its row in the pack."""
        facts = self.pack.episodes[number].facts
        at = int(self.first_instants[number] + self.pack.columns["at"][row])
        place = (row, at, int(self.first_actors[at]), int(self.first_lights[at]))
        route = route_of(self.data / "routes", facts["route"], facts["checksum"])
        return frame_of(
            self.pack.columns, place, route, targets=targets, inputs=inputs, seed=facts["seed"]
        )


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames of several folders, by number, in the order of folders and recordings.

    Attributes:
        targets: What their waypoints are.
        sources: Where they are.
        source: Of each frame, its place in `sources`.
        episode: Of each frame, the number of its episode in the source's pack.
        row: Of each frame, its row in the source's pack.
        routes: The route's id of each episode that there is, by (source, episode); in order.
        fingerprint: A hash of all that decides them.
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
        """Return a frame."""
        source = self.sources[self.source[number]]
        episode, row = int(self.episode[number]), int(self.row[number])
        return source.frame(episode, row, targets=self.targets, inputs=inputs)

    def route_mask(self, names: frozenset[str]) -> Bool[np.ndarray, " frames"]:
        """Return which frames are of some routes."""
        wanted = [place for place, name in self.routes.items() if name in names]
        most = 1 + max((episode for _, episode in self.routes), default=0)
        known = np.array([source * most + episode for source, episode in wanted], np.int64)
        return np.isin(self.source * most + self.episode, known)

    def stationary(self, chosen: Int[np.ndarray, " chosen"]) -> Bool[np.ndarray, " chosen"]:
        """Return where the ego stands and should go on standing."""
        name = "future" if self.targets == "future" else "answered"
        found = np.zeros(len(chosen), bool)
        for number, source in enumerate(self.sources):
            mine = np.flatnonzero(self.source[chosen] == number)
            rows, episodes = self.row[chosen[mine]], self.episode[chosen[mine]]
            columns = source.pack.columns
            at = source.first_instants[episodes] + columns["at"][rows]
            speed = columns["ego"][at, 3].astype(np.float32)
            ahead = columns[name][rows, LAST, 0]
            found[mine] = (speed < STANDING) & (np.abs(ahead) < STAYING)
        return found


@dataclass(frozen=True)
class _Task:
    recording: Path
    routes: Path


@cache
def frames_key() -> str:
    """Return what names the folder of frames: a hash of format, protocol and code."""
    code = closure_hash("plant_bench.training.frames")
    about = f"{FRAMES_FORMAT}|{PROTOCOL}|{code}"
    return hashlib.sha256(about.encode()).hexdigest()[:KEY_LENGTH]


def load_frames(
    folders: Sequence[Path],
    *,
    targets: TargetKind = "future",
    share: float = 1.0,
    workers: int = 1,
    on_progress: Progress | None = None,
) -> Frames:
    """Return the frames of data folders; makes what is missing.

    Args:
        folders: See above.
        targets: What the waypoints are. "future": where the ego went, as PlanT; where something
            disturbed the driver within that future it is not the driver's own, and the frame is
            left out. "expert-action": where the acceleration that the expert chose leads along the
            route if it is held; the expert need not have been the one who drove.
        share: Of the recordings, see `recordings_in`.
        workers: Processes that make what is missing.
        on_progress: Told how many of how many episodes are ready.

    Raises:
        InputError: A folder, a recording or its route cannot be used, or an answer is missing.
    """
    making = Making(_make, workers, on_progress)
    sources: list[Episodes] = []
    chosen: list[tuple[int, int, str]] = []
    for data in folders:
        names, packs = _episodes(data, targets, share, making)
        places = {
            episode.name: (len(sources) + place, number)
            for place, pack in enumerate(packs)
            for number, episode in enumerate(pack.episodes)
        }
        sources += [Episodes(data, pack) for pack in packs]
        chosen += [(*places[name], name) for name in names]
    return _joined(sources, chosen, targets)


def _episodes(
    data: Path, targets: TargetKind, share: float, making: Making
) -> tuple[list[str], list[ColumnStore]]:
    recordings = recordings_in(data, share)
    check_targets(data, targets)
    routes = data / "routes"
    if not any(routes.glob("*.json")):
        message = f"No routes (*.json) found in {routes}: the routes driven are expected there."
        raise InputError(message)
    known_routes(routes)
    tasks = {f"{path.stem}-{_content(path)}": _Task(path, routes) for path in recordings}
    return list(tasks), open_packs(data / "frames" / frames_key(), tasks, making)


def _joined(
    sources: list[Episodes], chosen: list[tuple[int, int, str]], targets: TargetKind
) -> Frames:
    columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    digest = hashlib.sha256(f"{frames_key()}|{targets}".encode())
    routes: dict[tuple[int, int], str] = {}
    for place, number, name in chosen:
        source = sources[place]
        rows = _learnable(source, number, targets)
        columns.append((np.full(len(rows), place), np.full(len(rows), number), rows))
        routes[place, number] = source.pack.episodes[number].facts["route"]
        digest.update(f"|{name}|{routes[place, number]}".encode())
    source, episode, row = (
        np.concatenate([np.zeros(0, np.int64), *(item[axis] for item in columns)])
        for axis in range(3)
    )
    fingerprint = digest.hexdigest()[:16]
    return Frames(targets, tuple(sources), source, episode, row, routes, fingerprint)


def _learnable(source: Episodes, number: int, targets: TargetKind) -> Int[np.ndarray, " rows"]:
    """Return the rows of an episode that can be learned from."""
    first, end = source.first_frames[number : number + 2].tolist()
    rows = np.arange(first, end)
    if targets == "future":
        return rows[~source.pack.columns["disturbed"][first:end]]
    missing = np.isnan(source.pack.columns["answered"][first:end, FIRST, FIRST])
    if missing.any():
        name = source.pack.episodes[number].facts["recording"]
        at = source.pack.columns["at"][first + int(missing.argmax())]
        tick = source.pack.columns["tick"][source.first_instants[number] + at]
        message = f"{source.data / 'episodes' / name}: {no_answer(int(tick))}"
        raise InputError(message)
    return rows


def check_targets(data: Path, targets: TargetKind) -> None:
    """Check that what is to be learned is in a data folder.

    Raises:
        InputError: Another planner drove, and where it went is no example.
    """
    origin = DataFolder(data).origin()
    if origin is not None and origin.driver and targets == "future":
        message = (
            f"{data} holds the expert's answers while '{origin.driver}' drove: where that went is "
            "no example. Learn the answers: --targets expert-action."
        )
        raise InputError(message)


def recordings_in(data: Path, share: float = 1.0) -> list[Path]:
    """Return the recordings of a data folder, or the first share of them; by name.

    First are those of a route's first repetition, then of its second, as in PlanT's 1x, 2x and 3x
    data; within a repetition a hash of the name decides, so that a share is of all towns. A smaller
    share is a part of any larger one.

    Raises:
        InputError: There are none.
    """
    found = episode_files(data)
    count = max(round(share * len(found)), 1)
    return sorted(sorted(found, key=_turn)[:count])


def _turn(recording: Path) -> tuple[int, bytes]:
    repetition = re.search(r"_r(\d+)_[0-9a-f]+$", recording.stem)
    digest = hashlib.sha256(recording.stem.encode()).digest()
    return (int(repetition[1]) if repetition else 0), digest


def _make(task: _Task) -> tuple[Rows, dict[str, Any]]:
    recording = Recording.load(task.recording)
    name = str(recording.metadata.get("route"))
    route = known_routes(task.routes).get(name)
    if route is None:
        message = f"{task.recording} is of route '{name}', which is not in {task.routes}."
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
    """Return a route of a data folder.

    Raises:
        InputError: It is not there any more, or another one has its name.
    """
    route = known_routes(folder).get(name)
    if route is None or route.checksum != checksum:
        message = f"{folder} does not hold route {name} any more as it was driven: put it back."
        raise InputError(message)
    return route


@lru_cache(maxsize=64)
def known_routes(folder: Path) -> dict[str, Route]:
    """Return the routes in a folder by id.

    Raises:
        InputError: They cannot be read.
    """
    return {route.id: route for route in load_suite(str(folder))}


@cache
def _content(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:KEY_LENGTH]
