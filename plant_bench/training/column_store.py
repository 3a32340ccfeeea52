"""Stores columns of many episodes on disk, one memory-mapped file per column.

FOLDER/parts/*.npz           the columns of one episode each, until they are packed
FOLDER/pack-*/*.npy          one column each: the rows of all episodes of the pack, concatenated
FOLDER/pack-*/episodes.json  the pack's episodes and their numbers of rows

Packs are written atomically and never changed. Missing episodes are added as a new pack, so each
episode is built only once.
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
ProgressCallback = Callable[[int, int], None]

LARGEST_PART = 2_000_000_000  # bytes, compressed or not; an episode has about 1 million
EPISODES_FILE, PARTS = "episodes.json", "parts"
_HEADER_SIZE = 256  # bytes; large enough for any shape
_MAGIC = b"\x93NUMPY\x01\x00"
_ZIP_ERRORS = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError)


@dataclass(frozen=True)
class Episode:
    """An episode in a pack.

    Attributes:
        name: Name of the episode, including a hash of its input.
        facts: Further values that its builder returned, JSON types only.
        rows: Number of rows by column.
    """

    name: str
    facts: dict[str, Any]
    rows: dict[str, int]


@dataclass(frozen=True, eq=False)
class ColumnStore:
    """A pack: the memory-mapped columns of some episodes.

    Attributes:
        folder: Folder of the pack.
        episodes: The episodes, in the order of their rows.
        columns: Columns by name; memory-mapped, so only the rows in use are read.
    """

    folder: Path
    episodes: tuple[Episode, ...]
    columns: dict[str, np.ndarray]

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the path only; the receiving process maps the files itself."""
        return open_pack, (self.folder,)


@dataclass(frozen=True)
class EpisodeBuilder:
    """Builds the columns of missing episodes.

    Attributes:
        build: Importable function that returns the columns and facts of an episode, given its task.
        workers: Number of processes.
        on_progress: Called with the number of finished episodes and their total number.
    """

    build: Callable[[Any], tuple[Columns, dict[str, Any]]]
    workers: int = 1
    on_progress: ProgressCallback | None = None


def open_packs(
    folder: Path, tasks: Mapping[str, Any], builder: EpisodeBuilder
) -> list[ColumnStore]:
    """Return all packs of a folder; first add a pack of the named episodes that are missing.

    Args:
        folder: Folder of the packs.
        tasks: Input of `EpisodeBuilder.build` by the episode's name; picklable.
        builder: Builds the missing episodes.

    Raises:
        InputError: A pack is broken, or an episode cannot be built.
    """
    packs = [open_pack(path) for path in sorted(folder.glob("pack-*")) if _is_complete(path)]
    there = {episode.name for pack in packs for episode in pack.episodes}
    missing = {name: task for name, task in tasks.items() if name not in there}
    if missing:
        _build_parts(folder / PARTS, missing, builder)
        packs.append(open_pack(_pack_parts(folder, list(missing))))
    return packs


def open_pack(folder: Path) -> ColumnStore:
    """Memory-map a pack.

    Raises:
        InputError: The pack is broken.
    """
    try:
        episodes = TypeAdapter(tuple[Episode, ...]).validate_python(
            read_json(folder / EPISODES_FILE)
        )
        names = {name for episode in episodes for name in episode.rows}
        columns = {name: _map_column(folder / f"{name}.npy") for name in sorted(names)}
        for name, values in columns.items():
            if len(values) != sum(episode.rows.get(name, 0) for episode in episodes):
                message = f"column '{name}' has {len(values)} rows, unlike {EPISODES_FILE}"
                raise ValueError(message)
    except (OSError, ValueError, KeyError, TypeError, EOFError) as error:
        message = f"Broken pack: {folder} ({in_one_line(error)}). Remove it; it is rebuilt."
        raise InputError(message) from error
    return ColumnStore(folder, episodes, columns)


def start_offsets(counts: np.ndarray) -> np.ndarray:
    """Return the start offset of each of several concatenated parts, and the end of the last one.

    >>> start_offsets(np.array([2, 0, 3])).tolist()
    [0, 2, 2, 5]
    """
    return np.concatenate(([0], np.cumsum(counts, dtype=np.int64)))


def _map_column(path: Path) -> np.ndarray:
    """Memory-map a column; returns an ordinary array, which is faster to index than a `memmap`."""
    if path.stat().st_size == _HEADER_SIZE:  # no rows: an empty file part cannot be mapped
        return np.load(path)
    return np.load(path, mmap_mode="r").view(np.ndarray)


def _is_complete(path: Path) -> bool:
    return path.suffix != UNFINISHED and path.is_dir()


def _build_parts(folder: Path, tasks: Mapping[str, Any], builder: EpisodeBuilder) -> None:
    """Build the missing part files; they are kept until they are packed."""
    missing = [
        _PartTask(folder / f"{name}.npz", task, builder.build)
        for name, task in tasks.items()
        if not (folder / f"{name}.npz").is_file()
    ]
    done = 0

    def on_event(event: Event) -> None:
        nonlocal done
        if isinstance(event, Lost):
            message = f"{missing[event.task].path.stem} cannot be built: {event.reason}"
            raise InputError(message)
        if isinstance(event, Finished):
            done += 1
            if builder.on_progress is not None:
                builder.on_progress(done, len(missing))

    if len(missing) == 1 or builder.workers == 1:  # in this process
        for place, task in enumerate(missing):
            _build_part(task, _no_report)
            on_event(Finished(0, place, None))
    elif missing:
        run_tasks(
            missing, _build_part, workers=min(builder.workers, len(missing)), on_event=on_event
        )


def _no_report(_share: float) -> None:
    """Ignore the progress of a part."""


@dataclass(frozen=True)
class _PartTask:
    path: Path
    task: Any
    build: Callable[[Any], tuple[Columns, dict[str, Any]]]


def _build_part(task: _PartTask, _report: Callable[[float], None]) -> None:
    columns, facts = task.build(task.task)
    with whole_file(task.path) as part, part.open("wb") as file:
        arrays: dict[str, Any] = {**columns, "facts__": np.array(json.dumps(facts))}
        np.savez_compressed(file, **arrays)


def _read_part(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    try:
        check_file(path, largest=LARGEST_PART)
        _check_unpacked_size(path)
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            columns = {name: file[name] for name in file.files}
            return columns, json.loads(str(columns.pop("facts__")))
    except (OSError, ValueError, KeyError, *_ZIP_ERRORS) as error:
        message = f"Broken part: {path} ({in_one_line(error)}). Remove the file; it is rebuilt."
        raise InputError(message) from error


def _check_unpacked_size(path: Path) -> None:
    """Check the uncompressed size: a small file can expand to more than the memory holds."""
    with zipfile.ZipFile(path) as file:
        size = sum(item.file_size for item in file.infolist())
    if size > LARGEST_PART:
        message = f"{size:,} bytes uncompressed, expected at most {LARGEST_PART:,}"
        raise ValueError(message)


def _pack_parts(folder: Path, names: Sequence[str]) -> Path:
    """Concatenate parts into a new pack; return its folder."""
    digest = hashlib.sha256("\n".join(names).encode()).hexdigest()[:12]
    pack = folder / f"pack-{digest}"
    parts = [folder / PARTS / f"{name}.npz" for name in names]
    try:
        with _atomic_folder(pack) as place:
            _write_pack(place, zip(names, map(_read_part, parts), strict=True))
    except InputError:
        if not pack.is_dir():  # otherwise another process wrote the same pack and removed the parts
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
def _atomic_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder; without an exception it is renamed to `folder` at the end."""
    place = folder.with_name(f"{folder.name}.{token_hex(4)}{UNFINISHED}")
    place.mkdir(parents=True)
    try:
        yield place
        try:
            place.rename(folder)
        except OSError:
            if not folder.is_dir():  # otherwise another process wrote the same pack
                raise
    finally:
        shutil.rmtree(place, ignore_errors=True)


class _ColumnWriter:
    """Writes a .npy file whose number of rows is not known in advance; mutable."""

    def __init__(self, path: Path, example: np.ndarray) -> None:
        self._file: IO[bytes] = path.open("wb")
        self._like, self._rows = example[:0], 0
        self._file.write(bytes(_HEADER_SIZE))

    def add(self, values: np.ndarray) -> None:
        """Append rows.

        Raises:
            InputError: Their type or shape differs from that of earlier rows.
        """
        if values.dtype != self._like.dtype or values.shape[1:] != self._like.shape[1:]:
            message = (
                f"Expected rows of {self._like.dtype} {self._like.shape[1:]} as before, got "
                f"{values.dtype} {values.shape[1:]}: all frames must give arrays of one shape."
            )
            raise InputError(message)
        self._file.write(np.ascontiguousarray(values).tobytes())
        self._rows += len(values)

    def close(self) -> None:
        """Write the header, flush the file to disk and close it."""
        shape = (self._rows, *self._like.shape[1:])
        header = {"descr": self._like.dtype.str, "fortran_order": False, "shape": shape}
        size = _HEADER_SIZE - len(_MAGIC) - 2
        text = repr(header).encode().ljust(size - 1) + b"\n"
        self._file.seek(0)
        self._file.write(_MAGIC + size.to_bytes(2, "little") + text)
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()
