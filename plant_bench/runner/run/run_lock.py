"""Locks a run's folder, or one shard of it, against other processes; also on network disks.

A lock is a small file in `claims/`. It is created exclusively, which only one process can do, also
over NFS. Only then are the other locks read, so of two conflicting owners at least one sees the
other. The owner refreshes the file's time every `HEARTBEAT` seconds. A lock whose process on this
host is dead is taken over at once; a lock of another host, after `EXPIRY` without a heartbeat.
"""

import json
import os
import secrets
import socket
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, TypeVar

from pydantic import Field, TypeAdapter

from plant_bench.atomic_files import whole_file
from plant_bench.errors import InputError
from plant_bench.untrusted_files import read_text

HEARTBEAT = 30.0  # s
EXPIRY = 300.0  # s without a heartbeat after which a lock of another host has expired
WHOLE = "whole"
LARGEST_LOCK = 10_000  # bytes
_Number = Annotated[int, Field(ge=0, lt=1 << 31)]
_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Shard:
    """One part of a run's episodes, driven separately from the others.

    Attributes:
        number: Number of the part, from 1.
        count: Number of parts.
    """

    number: int
    count: int

    @classmethod
    def parse(cls, text: str) -> "Shard":
        """Parse a shard such as "2/8".

        Raises:
            InputError: The text is not a shard.
        """
        number, _, count = text.partition("/")
        if number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
            return cls(int(number), int(count))
        message = f"Shard '{text}': expected I/N with I from 1 to N, as in 1/8."
        raise InputError(message)

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def of(self, items: Sequence[_Item], lengths: Sequence[float]) -> list[_Item]:
        """Return this shard's items: the longest first, each goes to the least loaded shard.

        The result depends on items and lengths alone, so all shards agree on the division.
        """
        order = sorted(range(len(items)), key=lambda index: (-lengths[index], index))
        loads = [0.0] * self.count
        chosen = []
        for index in order:
            least = min(range(self.count), key=lambda shard: (loads[shard], shard))
            loads[least] += lengths[index]
            if least == self.number - 1:
                chosen.append(index)
        return [items[index] for index in sorted(chosen)]


@dataclass(frozen=True)
class LockInfo:
    """Content of a lock file: its owner, and what is locked.

    Attributes:
        what: "whole", or a shard such as "2of8".
        version: Hash of all episodes that the shards divide.
        host: Name of the machine.
        pid: Process id on it.
        born: Start time of the process, in system ticks since boot; 0 if unknown.
        since: Time of locking, as shown to the user.
        token: Unique random text.
    """

    what: Annotated[str, Field(pattern=r"^(whole|[1-9][0-9]{0,8}of[1-9][0-9]{0,8})$")]
    version: str
    host: str
    pid: _Number
    born: Annotated[int, Field(ge=0)]
    since: str
    token: str

    def described(self) -> str:
        """Return a description of the owner for messages."""
        what = "A run" if self.what == WHOLE else f"Shard {self.what.replace('of', '/')}"
        return f"{what} (host {self.host}, process {self.pid}, since {self.since})"

    def conflicts(self, other: "LockInfo") -> bool:
        """Return whether two locks exclude each other; different shards of one division do not."""
        if WHOLE in (self.what, other.what) or self.version != other.version:
            return True
        number, count = self.what.split("of")
        other_number, other_count = other.what.split("of")
        return count != other_count or number == other_number


_READER = TypeAdapter(LockInfo)


@contextmanager
def locked(folder: Path, shard: Shard | None, version: str) -> Iterator[None]:
    """Lock a run's folder, or one shard of it, within the context.

    Args:
        folder: Folder of the run; created if it does not exist.
        shard: The part that is locked; None for the whole run.
        version: Hash of all episodes; shards of another division are refused.

    Raises:
        InputError: Another process holds a conflicting lock, or the folder is not writable.
    """
    what = WHOLE if shard is None else f"{shard.number}of{shard.count}"
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    host, pid = socket.gethostname(), os.getpid()
    info = LockInfo(what, version, host, pid, _start_time(pid), since, secrets.token_hex(8))
    lock_folder = folder / "claims"
    try:
        path = _acquire(lock_folder, info)
    except OSError as error:
        message = f"Cannot write to {folder}: {error.strerror}. Choose another with --out."
        raise InputError(message) from error
    ended = threading.Event()
    heartbeat = threading.Thread(target=_heartbeat, args=(path, ended), daemon=True)
    try:
        _check_others(lock_folder, path, info)
        heartbeat.start()
        yield
    finally:
        ended.set()
        if _read(path) == info:
            path.unlink(missing_ok=True)
        with _ignoring_os_errors():
            lock_folder.rmdir()  # if there is no other lock


def _acquire(lock_folder: Path, info: LockInfo) -> Path:
    """Create a lock file, replacing an expired one.

    Raises:
        InputError: Another process holds the lock.
    """
    path = lock_folder / f"{info.what}.json"
    for _ in range(3):
        lock_folder.mkdir(parents=True, exist_ok=True)
        try:
            with whole_file(path, new=True) as part:
                part.write_text(json.dumps(asdict(info)), encoding="utf-8")
        except FileExistsError:
            lock_owner = _read(path)
            if lock_owner is not None:
                if not _has_expired(path, lock_owner):
                    raise _lock_error(lock_owner, path) from None
                _remove_expired(path, lock_owner)
        except FileNotFoundError:
            continue  # the owner of the last lock has just removed the folder
        else:
            return path
    message = f"{path} is locked and released by other processes repeatedly. Try again."
    raise InputError(message)


def _check_others(lock_folder: Path, own_path: Path, info: LockInfo) -> None:
    for path in sorted(lock_folder.glob("*.json")):
        lock_owner = None if path == own_path else _read(path)
        if lock_owner is None or not info.conflicts(lock_owner):
            continue
        if not _has_expired(path, lock_owner):
            raise _lock_error(lock_owner, path)
        _remove_expired(path, lock_owner)


def _lock_error(lock_owner: LockInfo, path: Path) -> InputError:
    return InputError(
        f"{lock_owner.described()} is writing to {path.parents[1]}. Wait until it has ended, or "
        f"choose another folder with --out. (A lock of another host expires "
        f"{EXPIRY / 60.0:.0f} minutes after its last heartbeat; if you know that its process has "
        f"ended, remove {path}.)"
    )


def _has_expired(path: Path, lock_owner: LockInfo) -> bool:
    """Return whether the owner of a lock has certainly ended."""
    if lock_owner.host == socket.gethostname():
        return (
            _start_time(lock_owner.pid) != lock_owner.born
            if lock_owner.born
            else not _is_running(lock_owner.pid)
        )
    return _age(path) > EXPIRY


def _age(path: Path) -> float:
    """Return the seconds since a lock's last heartbeat, by the clock of its file system."""
    probe = path.with_name(f"{secrets.token_hex(8)}.now")
    try:
        with probe.open("x"):
            now = probe.stat().st_mtime
        with path.open("rb") as file:  # opening makes NFS query the server
            return now - os.fstat(file.fileno()).st_mtime
    except FileNotFoundError:
        return 0.0
    finally:
        probe.unlink(missing_ok=True)


def _remove_expired(path: Path, lock_owner: LockInfo) -> None:
    """Remove an expired lock, unless another process has just replaced it."""
    aside = path.with_name(f"{secrets.token_hex(8)}.void")
    try:
        path.rename(aside)
    except FileNotFoundError:
        return
    if _read(aside) != lock_owner:
        with _ignoring_os_errors():
            os.link(aside, path)
    aside.unlink(missing_ok=True)


def _read(path: Path) -> LockInfo | None:
    """Return the content of a lock file; None if it is gone, an unknown owner if it is broken."""
    try:
        return _READER.validate_json(read_text(path, largest=LARGEST_LOCK), strict=True)
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        return LockInfo(WHOLE, "", "unknown", 0, 0, "unknown", "")


def _heartbeat(path: Path, ended: threading.Event) -> None:
    while not ended.wait(HEARTBEAT):
        with _ignoring_os_errors():
            os.utime(path)


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _start_time(pid: int) -> int:
    """Return the start time of a process, in ticks since boot; 0 if unknown or not running."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return 0
    return int(text.rpartition(")")[2].split()[19])


@contextmanager
def _ignoring_os_errors() -> Iterator[None]:
    try:
        yield
    except OSError:
        return
