"""The samples of a data folder, made once and kept: one compressed file an episode.

DIR/routes/*.json          the routes driven (suite files)
DIR/episodes/*.parquet     recordings; their metadata names the route
DIR/samples/<key>/*.npz    what is made of them; the key is a hash of the code and spec that made it

A finished file is never made again, so the same command goes on where it was stopped.
"""

import hashlib
import json
import re
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from plant_bench.data.recording import Recording
from plant_bench.data.statistics import episode_files
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenSpec
from plant_bench.input_files import check_file
from plant_bench.runner.collect.data_folder import DataFolder
from plant_bench.runner.workers.executors import Event, Finished, Lost, run_tasks
from plant_bench.runner.workers.worker import Report
from plant_bench.training.samples import Samples, TargetKind, samples_of
from plant_bench.whole_files import whole_file
from plant_bench.world.route import PROTOCOL, Route, load_suite

SHARD_FORMAT = 1
KEY_LENGTH = 12
LARGEST_SHARD = 2_000_000_000  # bytes, packed or not; an episode has about 1 million
_PACKAGE = Path(__file__).parents[1]
_CODE = (  # what decides the numbers of a sample
    *sorted((_PACKAGE / "features").glob("*.py")),
    _PACKAGE / "training" / "samples.py",
    _PACKAGE / "agents" / "careful" / "driver.py",
    _PACKAGE / "agents" / "careful" / "forecast.py",
    _PACKAGE / "agents" / "careful" / "rollouts.py",
    _PACKAGE / "agent.py",
    _PACKAGE / "sensing" / "observe.py",
    _PACKAGE / "world" / "route_progress.py",
    _PACKAGE / "geometry" / "polyline.py",
    _PACKAGE / "geometry" / "pose.py",
)


@dataclass(frozen=True)
class Shard:
    """The samples of one episode.

    Attributes:
        route: The route's id: training and validation are told apart by it.
        samples: What was seen and done.
    """

    route: str
    samples: Samples


@dataclass(frozen=True)
class _Task:
    recording: Path
    shard: Path
    routes: Path
    spec: TokenSpec
    targets: TargetKind


def shards_key(spec: TokenSpec, targets: TargetKind = "future") -> str:
    """Return what names the folder of samples: a hash of format, code, spec and targets."""
    about = f"{SHARD_FORMAT}|{PROTOCOL}|{targets}|{json.dumps(asdict(spec), sort_keys=True)}"
    digest = hashlib.sha256(about.encode())
    for path in _CODE:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:KEY_LENGTH]


def load_shards(
    data: Path,
    spec: TokenSpec,
    *,
    targets: TargetKind = "future",
    share: float = 1.0,
    workers: int = 1,
    on_progress: Callable[[int, int], None] | None = None,
) -> list[Shard]:
    """Return the samples of a data folder, in the order of the recordings' names.

    Args:
        data: The data folder, see above.
        spec: What becomes a token.
        targets: What the waypoints are, see `samples_of`.
        share: Of the recordings, see `recordings_in`.
        workers: Processes that make what is missing.
        on_progress: Told how many of how many episodes are ready.

    Raises:
        InputError: The folder, a recording or its route cannot be used.
    """
    recordings = recordings_in(data, share)
    check_targets(data, targets)
    routes = data / "routes"
    if not any(routes.glob("*.json")):
        message = f"No routes (*.json) found in {routes}: the routes driven are wanted there."
        raise InputError(message)
    folder = data / "samples" / shards_key(spec, targets)
    folder.mkdir(parents=True, exist_ok=True)
    names = {path: folder / f"{path.stem}-{_content(path)}.npz" for path in recordings}
    missing = [path for path, shard in names.items() if not shard.is_file()]
    _make(
        [_Task(path, names[path], routes, spec, targets) for path in missing], workers, on_progress
    )
    return [_read(shard) for shard in names.values()]


def check_targets(data: Path, targets: TargetKind) -> None:
    """Check that what is to be learned is in a data folder.

    Raises:
        InputError: Another planner drove, and where it went is no example.
    """
    origin = DataFolder(data).origin()
    if origin is not None and origin.driver and targets == "future":
        message = (
            f"{data} holds the expert's answers while '{origin.driver}' drove: where that went is "
            "no example. Learn the answers: --targets answer."
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


def _make(tasks: list[_Task], workers: int, on_progress: Callable[[int, int], None] | None) -> None:
    done = 0

    def listen(event: Event) -> None:
        nonlocal done
        if isinstance(event, Lost):
            message = f"No samples can be made of {tasks[event.task].recording}: {event.reason}"
            raise InputError(message)
        if isinstance(event, Finished):
            done += 1
            if on_progress is not None:
                on_progress(done, len(tasks))

    if len(tasks) == 1 or workers == 1:  # not worth a process
        for place, task in enumerate(tasks):
            _make_shard(task, lambda _: None)
            listen(Finished(0, place, None))
    elif tasks:
        run_tasks(tasks, _make_shard, workers=min(workers, len(tasks)), on_event=listen)


def _make_shard(task: _Task, _report: Report) -> None:
    recording = Recording.load(task.recording)
    name = str(recording.metadata.get("route"))
    route = _routes(task.routes).get(name)
    if route is None:
        message = f"{task.recording} is of route '{name}', which is not in {task.routes}."
        raise InputError(message)
    try:
        samples = samples_of(recording, route, task.spec, task.targets)
    except InputError as error:
        message = f"{task.recording}: {error}"
        raise InputError(message) from error
    columns: dict[str, Any] = {item.name: getattr(samples, item.name) for item in fields(Samples)}
    with whole_file(task.shard) as part, part.open("wb") as file:
        np.savez_compressed(file, route=np.array(name), **columns)


_UNZIPPING = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    MemoryError,
)


def _check_unpacked(path: Path) -> None:
    """Check what unpacking would need before it is done.

    Raises:
        OSError: It cannot be read.
        ValueError: It would be too large; as what zipfile raises.
    """
    check_file(path, largest=LARGEST_SHARD)
    with zipfile.ZipFile(path) as packed:
        size = sum(item.file_size for item in packed.infolist())
    if size > LARGEST_SHARD:
        message = f"{size:,} bytes when unpacked"
        raise ValueError(message)


def _read(path: Path) -> Shard:
    try:
        _check_unpacked(path)
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            columns = {item.name: file[item.name] for item in fields(Samples)}
            return Shard(str(file["route"]), Samples(**columns))
    except (OSError, ValueError, KeyError, *_UNZIPPING) as error:
        message = f"Broken samples: {path} ({error}). Remove the file; it is made again."
        raise InputError(message) from error


@lru_cache(maxsize=1)
def _routes(folder: Path) -> dict[str, Route]:
    return {route.id: route for route in load_suite(str(folder))}


@cache
def _content(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:KEY_LENGTH]
