"""Who drives into a run's folder: claims of whole runs and of shards, right on network disks too.

A claim is a small file in `claims/`. It is made by `O_EXCL`, which one process alone can win, also
over NFS; only then are the others read, so of two that conflict at least one sees the other. A
claim is beaten (its time is set) now and then. One of a dead process of this host is taken over at
once, one of another host when it has not been beaten for long.
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
EXPIRY = 300.0  # s without a beat after which a claim of another host is void
WHOLE = "whole"
LARGEST_CLAIM = 10_000  # bytes
_Number = Annotated[int, Field(ge=0, lt=1 << 31)]
_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Shard:
    """One of several parts of a run's episodes that are driven apart.

    Attributes:
        number: From 1.
        count: Of the parts.
    """

    number: int
    count: int

    @classmethod
    def parse(cls, text: str) -> "Shard":
        """Return what "2/8" means.

        Raises:
            InputError: It means nothing.
        """
        number, _, count = text.partition("/")
        if number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
            return cls(int(number), int(count))
        message = f"Shard '{text}': expected I/N with I from 1 to N, as in 1/8."
        raise InputError(message)

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def of(self, items: Sequence[_Item], lengths: Sequence[float]) -> list[_Item]:
        """Return this shard's part: each item goes, the longest first, where least is yet.

        It depends on items and lengths alone, so all shards agree on who has what.
        """
        order = sorted(range(len(items)), key=lambda place: (-lengths[place], place))
        loads = [0.0] * self.count
        mine = []
        for place in order:
            least = min(range(self.count), key=lambda shard: (loads[shard], shard))
            loads[least] += lengths[place]
            if least == self.number - 1:
                mine.append(place)
        return [items[place] for place in sorted(mine)]


@dataclass(frozen=True)
class LockInfo:
    """Who claims, and what.

    Attributes:
        what: "whole", or a shard as "2of8".
        version: Of what is driven: all episodes that the shards divide.
        host: The machine.
        pid: The process there.
        born: When that process started, in the system's ticks since its boot; 0 where unknown.
        since: When it was claimed, for people.
        token: No two claims have the same.
    """

    what: Annotated[str, Field(pattern=r"^(whole|[1-9][0-9]{0,8}of[1-9][0-9]{0,8})$")]
    version: str
    host: str
    pid: _Number
    born: Annotated[int, Field(ge=0)]
    since: str
    token: str

    def described(self) -> str:
        """Say who it is."""
        what = "A run" if self.what == WHOLE else f"Shard {self.what.replace('of', '/')}"
        return f"{what} (host {self.host}, process {self.pid}, since {self.since})"

    def conflicts(self, other: "LockInfo") -> bool:
        """Tell whether two may not drive at the same time: only shards of one division may."""
        if WHOLE in (self.what, other.what) or self.version != other.version:
            return True
        number, count = self.what.split("of")
        other_number, other_count = other.what.split("of")
        return count != other_count or number == other_number


_READER = TypeAdapter(LockInfo)


@contextmanager
def claimed(folder: Path, shard: Shard | None, version: str) -> Iterator[None]:
    """Have a run's folder, or one shard of it, as long as the context lasts.

    Args:
        folder: The run's; it is made if it is not there.
        shard: What is claimed; None for the whole.
        version: Of what is driven; shards of another one are refused.

    Raises:
        InputError: Somebody else has it, or it cannot be written to.
    """
    what = WHOLE if shard is None else f"{shard.number}of{shard.count}"
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    host, pid = socket.gethostname(), os.getpid()
    me = LockInfo(what, version, host, pid, _born(pid), since, secrets.token_hex(8))
    place = folder / "claims"
    try:
        mine = _claim(place, me)
    except OSError as error:
        message = f"Cannot write to {folder}: {error.strerror}. Choose another with --out."
        raise InputError(message) from error
    ended = threading.Event()
    beating = threading.Thread(target=_beat, args=(mine, ended), daemon=True)
    try:
        _check_others(place, mine, me)
        beating.start()
        yield
    finally:
        ended.set()
        if _read(mine) == me:
            mine.unlink(missing_ok=True)
        with _ignored():
            place.rmdir()  # if nobody else has a claim


def _claim(place: Path, me: LockInfo) -> Path:
    """Make the file of a claim, over a void one too.

    Raises:
        InputError: Somebody has it.
    """
    path = place / f"{me.what}.json"
    for _ in range(3):
        place.mkdir(parents=True, exist_ok=True)
        try:
            with whole_file(path, new=True) as part:
                part.write_text(json.dumps(asdict(me)), encoding="utf-8")
        except FileExistsError:
            lock_owner = _read(path)
            if lock_owner is not None:
                if not _void(path, lock_owner):
                    raise _refusal(lock_owner, path) from None
                _take_away(path, lock_owner)
        except FileNotFoundError:
            continue  # who held the last claim has just removed the folder
        else:
            return path
    message = f"{path} is claimed and given up by others over and over. Try again."
    raise InputError(message)


def _check_others(place: Path, mine: Path, me: LockInfo) -> None:
    for path in sorted(place.glob("*.json")):
        lock_owner = None if path == mine else _read(path)
        if lock_owner is None or not me.conflicts(lock_owner):
            continue
        if not _void(path, lock_owner):
            raise _refusal(lock_owner, path)
        _take_away(path, lock_owner)


def _refusal(lock_owner: LockInfo, path: Path) -> InputError:
    return InputError(
        f"{lock_owner.described()} is driving into {path.parents[1]}. Wait until it has ended, or "
        f"choose another folder with --out. (What another host claims is void "
        f"{EXPIRY / 60.0:.0f} minutes after its last sign of life; if you know that it has ended, "
        f"remove {path}.)"
    )


def _void(path: Path, lock_owner: LockInfo) -> bool:
    """Tell whether who made a claim is certainly gone."""
    if lock_owner.host == socket.gethostname():
        return (
            _born(lock_owner.pid) != lock_owner.born
            if lock_owner.born
            else not _lives(lock_owner.pid)
        )
    return _age(path) > EXPIRY


def _age(path: Path) -> float:
    """Return the seconds since a claim was beaten, by the clock of the disk it lies on."""
    probe = path.with_name(f"{secrets.token_hex(8)}.now")
    try:
        with probe.open("x"):
            now = probe.stat().st_mtime
        with path.open("rb") as file:  # opened: NFS asks the server then
            return now - os.fstat(file.fileno()).st_mtime
    except FileNotFoundError:
        return 0.0
    finally:
        probe.unlink(missing_ok=True)


def _take_away(path: Path, lock_owner: LockInfo) -> None:
    """Remove a void claim, unless another process has just done so and made its own."""
    aside = path.with_name(f"{secrets.token_hex(8)}.void")
    try:
        path.rename(aside)
    except FileNotFoundError:
        return
    if _read(aside) != lock_owner:
        with _ignored():
            os.link(aside, path)
    aside.unlink(missing_ok=True)


def _read(path: Path) -> LockInfo | None:
    """Return who made a claim, None where it is gone; of a broken one nobody is known."""
    try:
        return _READER.validate_json(read_text(path, largest=LARGEST_CLAIM), strict=True)
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        return LockInfo(WHOLE, "", "unknown", 0, 0, "unknown", "")


def _beat(path: Path, ended: threading.Event) -> None:
    while not ended.wait(HEARTBEAT):
        with _ignored():
            os.utime(path)


def _lives(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _born(pid: int) -> int:
    """Return when a process started, in ticks since boot; 0 where there is none or none can say."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return 0
    return int(text.rpartition(")")[2].split()[19])


@contextmanager
def _ignored() -> Iterator[None]:
    try:
        yield
    except OSError:
        return
