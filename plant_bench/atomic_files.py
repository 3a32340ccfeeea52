"""Atomic file writes: a file has its complete content or does not exist, even after a power cut.

A file is written under a temporary name, synced to disk, renamed, and its folder is synced.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex

UNFINISHED = ".part"  # ends the names of files that are being written
_LONGEST_NAME = 255  # bytes, of most file systems


@contextmanager
def whole_file(path: Path, *, new: bool = False) -> Iterator[Path]:
    """Give where to write a file, and put it in its place if nothing was raised; makes its folder.

    The place given is new each time: who waits there with a link, or writes the same file in
    another process, is not met.

    Args:
        path: The file; one that is there is replaced.
        new: There must be none: of several who write it at once one succeeds.

    Raises:
        FileExistsError: It is there, and was to be new.
        OSError: It cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    ending = f".{token_hex(4)}{UNFINISHED}"
    part = path.with_name(path.name[: _LONGEST_NAME - len(ending)] + ending)
    try:
        yield part
        _to_disk(part)
        if new:
            os.link(part, path)  # fails where there is one
        else:
            part.replace(path)
        _to_disk(path.parent)
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file by a function that is told where to; as `whole_file`.

    Raises:
        OSError: It cannot be written.
    """
    with whole_file(path) as part:
        write(part)


def write_whole_text(path: Path, text: str) -> None:
    """Write a text file, UTF-8 with plain line ends; as `whole_file`.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, lambda part: part.write_text(text, encoding="utf-8", newline="\n"))


def move_whole(source: Path, target: Path) -> None:
    """Move a finished file within a file system; it is in one of the two places at any time.

    Raises:
        OSError: It cannot be moved.
    """
    source.replace(target)
    _to_disk(target.parent)


def _to_disk(path: Path) -> None:
    """Wait until a file's content, or a folder's list of names, is on the disk."""
    if path.is_dir() and os.name == "nt":
        return  # Windows opens no folders
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
