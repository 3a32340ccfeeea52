"""Fault injection for `benchmarks/kills.py`: ends one of its Python processes at a given time.

FAULT is "PROCESS:INSTANT:NUMBER:ACTION": in the parent or a worker, at the NUMBER-th time that
INSTANT of writing a file comes, once in a run (FAULT_ONCE is a file that tells whether it has).
"""

import errno
import os
import resource
import signal
import sys
from pathlib import Path


def _is_worker() -> bool:
    return "--multiprocessing-fork" in sys.orig_argv


def _first() -> bool:
    """Tell whether no process of this run has had its fault yet."""
    try:
        os.close(os.open(os.environ["FAULT_ONCE"], os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return False
    return True


class Fault:
    """Counts the instants of this process, and strikes at one; mutable."""

    def __init__(self, instant: str, number: int, action: str) -> None:
        self.instant, self.number, self.action = instant, number, action

    def at(self, instant: str, path: Path) -> None:
        """Say that an instant has come; `path` is what a power cut now would harm."""
        if instant != self.instant:
            return
        self.number -= 1
        if self.number != 0 or not _first():
            return
        if self.action == "full":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if self.action == "cut":
            _lose(path, renamed=instant == "renamed")
        os.kill(os.getppid() if self.action == "kill-parent" else os.getpid(), signal.SIGKILL)


def _lose(path: Path, *, renamed: bool) -> None:
    """Lose what was not on the disk yet: a renaming, or half of a file's content."""
    if renamed:
        path.unlink(missing_ok=True)
    elif path.is_file():
        os.truncate(path, path.stat().st_size // 2)


def _install(fault: Fault) -> None:
    """Let the one function that brings files to the disk tell of its instants."""
    from plant_bench import atomic_files as whole_files

    to_disk, replace = whole_files._to_disk, Path.replace

    def told_to_disk(path: Path) -> None:
        fault.at("folder" if path.is_dir() else "written", path)
        to_disk(path)
        fault.at("folder synced" if path.is_dir() else "synced", path)

    def told_replace(self: Path, target: Path) -> Path:
        fault.at("renaming", self)
        found = replace(self, target)
        fault.at("renamed", Path(target))
        return found

    whole_files._to_disk, Path.replace = told_to_disk, told_replace


def _limit(size: int, *, deadly: bool) -> None:
    """End the process, or fail its write, when a file of it grows beyond a size in bytes."""
    if _first():
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL if deadly else signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


if "FAULT" in os.environ:
    _process, _instant, _number, _action = os.environ["FAULT"].split(":")
    if _is_worker() == (_process == "worker"):
        if _instant == "bytes":
            _limit(int(_number), deadly=_action == "kill")
        else:
            _install(Fault(_instant, int(_number), _action))
