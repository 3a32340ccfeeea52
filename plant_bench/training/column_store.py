"""Stores columns of many episodes on disk, one memory-mapped file per column.

FOLDER/parts/*.npz           of one episode each, until they are packed
FOLDER/pack-*/*.npy          a column of some episodes, one after the other
FOLDER/pack-*/episodes.json  which episodes, and how many rows each has

A pack appears whole or not at all: it is written in a folder of another name. What is missing goes
into a further pack, so a folder that has grown, or of which more is used, makes nothing twice.
"""

import hashlib
import json
import os
import shutil
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex
from typing import IO, Any

import numpy as np
from pydantic import TypeAdapter

from plant_bench.atomic_files import UNFINISHED, whole_file, write_whole_text
from plant_bench.errors import InputError, in_one_line
from plant_bench.runner.workers.executors import Event, Finished, Lost, run_tasks
from plant_bench.untrusted_files import check_file, read_json

Columns = Mapping[str, np.ndarray]
Progress = Callable[[int, int], None]

LARGEST_PART = 2_000_000_000  # bytes, packed or not; an episode has about 1 million
EPISODES_FILE, PARTS = "episodes.json", "parts"
_HEADER = 256  # bytes, room for any shape
_MAGIC = b"\x93NUMPY\x01\x00"
_UNZIPPING = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError)


@dataclass(frozen=True)
class Episode:
    """An episode in a pack.

    Attributes:
        name: Of the episode, with a hash of what it is made of.
        facts: What else is known of it.
        rows: How many rows it has of each column.
    """

    name: str
    facts: dict[str, Any]
    rows: dict[str, int]


@dataclass(frozen=True, eq=False)
class ColumnStore:
    """Some episodes.

    Attributes:
        folder: Where they are.
        episodes: In their order.
        columns: Mapped; nothing is read before it is used.
    """

    folder: Path
    episodes: tuple[Episode, ...]
    columns: dict[str, np.ndarray]

    def __reduce__(self) -> tuple[Any, ...]:
        """Let other processes map it themselves."""
        return open_pack, (self.folder,)


@dataclass(frozen=True)
class Making:
    """How what is missing is made.

    Attributes:
        work: An importable function that returns columns and facts of a task.
        workers: Processes.
        on_progress: Told how many of how many episodes are ready.
    """

    work: Callable[[Any], tuple[Columns, dict[str, Any]]]
    workers: int = 1
    on_progress: Progress | None = None


def open_packs(folder: Path, tasks: Mapping[str, Any], making: Making) -> list[ColumnStore]:
    """Return packs that hold the named episodes, and perhaps others; makes what is missing.

    Args:
        folder: Of the packs.
        tasks: What an episode is made from, by its name; picklable.
        making: How.

    Raises:
        InputError: A pack is broken, or an episode cannot be made.
    """
    packs = [open_pack(path) for path in sorted(folder.glob("pack-*")) if _is_whole(path)]
    there = {episode.name for pack in packs for episode in pack.episodes}
    missing = {name: task for name, task in tasks.items() if name not in there}
    if missing:
        _make_parts(folder / PARTS, missing, making)
        packs.append(open_pack(_packed(folder, list(missing))))
    return packs


def open_pack(folder: Path) -> ColumnStore:
    """Map a pack.

    Raises:
        InputError: It is broken.
    """
    try:
        episodes = TypeAdapter(tuple[Episode, ...]).validate_python(
            read_json(folder / EPISODES_FILE)
        )
        names = {name for episode in episodes for name in episode.rows}
        columns = {name: _mapped(folder / f"{name}.npy") for name in sorted(names)}
        for name, values in columns.items():
            if len(values) != sum(episode.rows.get(name, 0) for episode in episodes):
                message = f"column '{name}' has {len(values)} rows, not those of its episodes"
                raise ValueError(message)
    except (OSError, ValueError, KeyError, TypeError, EOFError) as error:
        message = f"Broken pack: {folder} ({in_one_line(error)}). Remove it; it is made again."
        raise InputError(message) from error
    return ColumnStore(folder, episodes, columns)


def starts_of(counts: np.ndarray) -> np.ndarray:
    """Return where each of some parts starts, and at the end where the last one ends.

    >>> starts_of(np.array([2, 0, 3])).tolist()
    [0, 2, 2, 5]
    """
    return np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))


def _mapped(path: Path) -> np.ndarray:
    """Return a column as an ordinary array, which is quicker to cut than a `memmap`."""
    if path.stat().st_size == _HEADER:  # nothing can be mapped
        return np.load(path)
    return np.load(path, mmap_mode="r").view(np.ndarray)


def _is_whole(path: Path) -> bool:
    return path.suffix != UNFINISHED and path.is_dir()


def _make_parts(folder: Path, tasks: Mapping[str, Any], making: Making) -> None:
    """Make a file for each task that has none; they are kept until they are packed."""
    missing = [
        _PartTask(folder / f"{name}.npz", task, making.work)
        for name, task in tasks.items()
        if not (folder / f"{name}.npz").is_file()
    ]
    done = 0

    def listen(event: Event) -> None:
        nonlocal done
        if isinstance(event, Lost):
            message = f"{missing[event.task].path.stem} cannot be made: {event.reason}"
            raise InputError(message)
        if isinstance(event, Finished):
            done += 1
            if making.on_progress is not None:
                making.on_progress(done, len(missing))

    if len(missing) == 1 or making.workers == 1:  # not worth a process
        for place, task in enumerate(missing):
            _make_part(task, _no_report)
            listen(Finished(0, place, None))
    elif missing:
        run_tasks(missing, _make_part, workers=min(making.workers, len(missing)), on_event=listen)


def _no_report(_share: float) -> None:
    """Report nothing."""


@dataclass(frozen=True)
class _PartTask:
    path: Path
    task: Any
    work: Callable[[Any], tuple[Columns, dict[str, Any]]]


def _make_part(task: _PartTask, _report: Callable[[float], None]) -> None:
    columns, facts = task.work(task.task)
    with whole_file(task.path) as part, part.open("wb") as file:
        arrays: dict[str, Any] = {**columns, "facts__": np.array(json.dumps(facts))}
        np.savez_compressed(file, **arrays)


def _read_part(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    try:
        check_file(path, largest=LARGEST_PART)
        _check_unpacked(path)
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            columns = {name: file[name] for name in file.files}
            return columns, json.loads(str(columns.pop("facts__")))
    except (OSError, ValueError, KeyError, *_UNZIPPING) as error:
        message = f"Broken part: {path} ({in_one_line(error)}). Remove the file; it is made again."
        raise InputError(message) from error


def _check_unpacked(path: Path) -> None:
    """Check what reading would need: a small file can hold a great many zeros."""
    with zipfile.ZipFile(path) as file:
        size = sum(item.file_size for item in file.infolist())
    if size > LARGEST_PART:
        message = f"{size:,} bytes unpacked"
        raise ValueError(message)


def _packed(folder: Path, names: Sequence[str]) -> Path:
    """Put parts together into a new pack, one after the other; return its folder."""
    digest = hashlib.sha256("\n".join(names).encode()).hexdigest()[:12]
    pack = folder / f"pack-{digest}"
    parts = [folder / PARTS / f"{name}.npz" for name in names]
    try:
        with _whole_folder(pack) as place:
            _write_pack(place, zip(names, map(_read_part, parts), strict=True))
    except InputError:
        if not pack.is_dir():  # otherwise another process was faster, and has cleared away
            raise
    for part in parts:
        part.unlink(missing_ok=True)
    return pack


def _write_pack(folder: Path, parts: Iterable[tuple[str, tuple[Columns, dict[str, Any]]]]) -> None:
    episodes: list[dict[str, Any]] = []
    with ExitStack() as opened:
        writers: dict[str, _ColumnWriter] = {}
        for name, (columns, facts) in parts:
            rows = {column: len(values) for column, values in columns.items()}
            episodes.append({"name": name, "facts": facts, "rows": rows})
            for column, values in columns.items():
                if column not in writers:
                    writers[column] = _ColumnWriter(folder / f"{column}.npy", values)
                    opened.enter_context(closing(writers[column]))
                writers[column].add(values)
    write_whole_text(folder / EPISODES_FILE, json.dumps(episodes))


@contextmanager
def _whole_folder(folder: Path) -> Iterator[Path]:
    """Give where to write a folder, and put it in its place if nothing was raised."""
    place = folder.with_name(f"{folder.name}.{token_hex(4)}{UNFINISHED}")
    place.mkdir(parents=True)
    try:
        yield place
        try:
            place.rename(folder)
        except OSError:
            if not folder.is_dir():  # otherwise another process was faster, with the same
                raise
    finally:
        shutil.rmtree(place, ignore_errors=True)


class _ColumnWriter:
    """Writes a .npy file whose length is known at its end only; mutable."""

    def __init__(self, path: Path, example: np.ndarray) -> None:
        self._file: IO[bytes] = path.open("wb")
        self._like, self._rows = example[:0], 0
        self._file.write(bytes(_HEADER))

    def add(self, values: np.ndarray) -> None:
        """Write more rows.

        Raises:
            InputError: They are not like those before.
        """
        if values.dtype != self._like.dtype or values.shape[1:] != self._like.shape[1:]:
            message = (
                f"Rows of {values.dtype} {values.shape[1:]} found where {self._like.dtype} "
                f"{self._like.shape[1:]} were before: all frames must give arrays of one shape."
            )
            raise InputError(message)
        self._file.write(np.ascontiguousarray(values).tobytes())
        self._rows += len(values)

    def close(self) -> None:
        """Write how long it has become, and bring all to the disk."""
        shape = (self._rows, *self._like.shape[1:])
        about = {"descr": self._like.dtype.str, "fortran_order": False, "shape": shape}
        room = _HEADER - len(_MAGIC) - 2
        text = repr(about).encode().ljust(room - 1) + b"\n"
        self._file.seek(0)
        self._file.write(_MAGIC + room.to_bytes(2, "little") + text)
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()
