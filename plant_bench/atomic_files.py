"""Atomic file writes: a file has its complete content or does not exist, even after a power cut.

A file is written under a temporary name, synced to disk, renamed, and its folder is synced.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex

UNFINISHED = ".part"  # suffix of files that are being written
_LONGEST_NAME = 255  # bytes, the limit of most file systems


@contextmanager
def whole_file(path: Path, *, new: bool = False) -> Iterator[Path]:
    """Yield a temporary path to write to, and rename it to `path` if no exception was raised.

    The temporary name is random, so that neither a prepared symbolic link nor another process
    writing the same file interferes. The folder is created if needed.

    Args:
        path: The file; an existing one is replaced.
        new: Whether the file must not exist; only one of several concurrent writers succeeds.

    Raises:
        FileExistsError: The file exists although `new` is true.
        OSError: The file cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    ending = f".{token_hex(4)}{UNFINISHED}"
    part = path.with_name(path.name[: _LONGEST_NAME - len(ending)] + ending)
    try:
        yield part
        _to_disk(part)
        if new:
            os.link(part, path)  # fails if the file exists
        else:
            part.replace(path)
        _to_disk(path.parent)
    except OSError as error:
        if error.errno is not None and error.filename is None:  # a full disk names no file
            error.filename = str(path)
        raise
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file atomically with a function that gets the temporary path; see `whole_file`.

    Raises:
        OSError: The file cannot be written.
    """
    with whole_file(path) as part:
        write(part)


def write_whole_text(path: Path, text: str) -> None:
    """Write a text file atomically, in UTF-8 with Unix line ends; see `whole_file`.

    Raises:
        OSError: The file cannot be written.
    """
    write_whole(path, lambda part: part.write_text(text, encoding="utf-8", newline="\n"))


def move_whole(source: Path, target: Path) -> None:
    """Move a finished file atomically within a file system.

    Raises:
        OSError: The file cannot be moved.
    """
    source.replace(target)
    _to_disk(target.parent)


def _to_disk(path: Path) -> None:
    """Sync a file's content, or a folder's entries, to disk."""
    if path.is_dir() and os.name == "nt":
        return  # Windows cannot open folders
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
