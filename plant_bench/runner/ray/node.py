"""The Ray actor on a node, which supervises one worker process.

Simulators and planners run in a process of their own, the same as in a local run, not in the
actor: what a crash of it means can then be told from the loss of the node, in the same words as
locally, and libsumo has its one simulation a process. The actor knows no Ray either.
"""

import os
import re
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from plant_bench.errors import PlantBenchError
from plant_bench.runner.ray.payload import (
    NodePaths,
    Payload,
    Portable,
    check_arrived,
    differences,
    enter,
    facts,
    unpack,
)
from plant_bench.runner.workers.process_start import cause_of_death, start_process
from plant_bench.runner.workers.worker import Failed, Message, Ready, Report, Share, Work, serve

LISTEN = 1.0  # s for which one call waits for news
START = 120.0  # s in which a worker process must have started
LOG_PIECE = 2**20  # bytes of the worker's log that travel at once


@dataclass(frozen=True)
class Cannot:
    """Why this node cannot take part."""

    reason: str


@dataclass(frozen=True)
class Brought:
    """A task's value, and the files it has written, by their paths in the run's folder."""

    value: Any
    files: Mapping[str, bytes] = field(repr=False)


@dataclass(frozen=True)
class News:
    """What an actor has to tell: the worker's last message, and what it has printed."""

    message: Message | Cannot | None
    printed: bytes = b""


class NodeWorker:
    """One worker process and the folder it works in; mutable."""

    def __init__(self, here: Mapping[str, str] | None = None) -> None:
        _sweep()
        self._folder = Path(tempfile.mkdtemp(prefix=f"{_prefix()}{os.getpid()}-"))
        self._place = NodePaths(self._folder / "files", self._folder / "output")
        self._log = self._folder / "worker.log"
        self._facts = facts() if here is None else here
        self._read = 0
        self._process: tuple[Any, Connection] | None = None

    def start(self, payload: Payload, work: Work) -> News:
        """Take the payload and start the worker: `Ready`, or why that cannot be."""
        unequal = differences(payload.facts, self._facts)
        if unequal:
            return News(Cannot(unequal))
        self._cargo, self._work = payload, work
        try:
            unpack(payload, self._place)
            self._begin()
        except (PlantBenchError, OSError) as error:
            return News(Cannot(str(error)))
        message = self._next(START)
        if isinstance(message, Ready):
            return News(message, self._printed())
        reason = message.reason if isinstance(message, Failed) else "The worker does not start."
        return News(Cannot(reason), self._printed())

    def step(self, task: Portable | None) -> News:
        """Give the worker a task if there is one; return its next message, None for none yet."""
        if task is not None:
            if self._process is None:
                self._begin()
                first = self._next(START)
                if not isinstance(first, Ready):
                    self._end()
                    late = Failed("The worker does not start.")
                    return News(first if isinstance(first, Failed) else late, self._printed())
            self._say(task)
        message = self._next(LISTEN)
        if isinstance(message, Failed):
            self._end()  # what failed may have left the simulator in any state
        return News(message, self._printed())

    def close(self) -> None:
        """End the worker at once and remove its folder."""
        self._end()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _begin(self) -> None:
        main = sys.modules["__main__"]
        vars(main).pop("__file__", None)  # else the child would load Ray's main module again
        main.__spec__ = None
        given = (self._cargo, self._place, self._work, self._log)
        self._process = start_process(_serve_at, *given)

    def _say(self, task: Portable) -> None:
        assert self._process is not None  # noqa: S101
        try:
            self._process[1].send(task)
        except OSError:
            return  # it has died: its pipe will tell

    def _next(self, patience: float) -> Message | None:
        """Return the worker's next answer, else the last of its progress in so many seconds."""
        if self._process is None:
            return None
        process, pipe = self._process
        message: Message | None = None
        until = time.monotonic() + patience
        try:
            while pipe.poll(max(until - time.monotonic(), 0.0)):
                message = pipe.recv()
                if not isinstance(message, Share):
                    break
        except (EOFError, OSError):
            process.join()
            self._end()
            message = Failed(cause_of_death(process.exitcode or 0))
        return message

    def _end(self) -> None:
        if self._process is not None:
            process, pipe = self._process
            process.kill()
            process.join()
            pipe.close()
            self._process = None
        shutil.rmtree(self._place.output, ignore_errors=True)
        self._place.output.mkdir(parents=True, exist_ok=True)

    def _printed(self) -> bytes:
        if not self._log.is_file():
            return b""
        with self._log.open("rb") as file:
            file.seek(self._read)
            found = file.read(LOG_PIECE)
        self._read += len(found)
        return found


def _serve_at(pipe: Connection, payload: Payload, place: NodePaths, work: Work, log: Path) -> None:
    """Do tasks where the payload lies: the life of a worker process on a node."""
    place = enter(payload, place)
    try:
        check_arrived(payload, place)
    except (PlantBenchError, OSError) as error:
        traceback.print_exc()
        pipe.send(Failed(str(error), fatal=True))
        return
    serve(pipe, partial(_do, work, place), log)


def _do(work: Work, place: NodePaths, task: Portable, report: Report) -> Brought:
    """Do a task as it is here, and bring what it has written."""
    value = work(task.at(place), report)
    written = sorted(path for path in place.output.rglob("*") if path.is_file())
    files = {path.relative_to(place.output).as_posix(): path.read_bytes() for path in written}
    for path in written:
        path.unlink()
    return Brought(value, files)


def _prefix() -> str:
    return f"plant-bench-{os.getuid()}-"


def _sweep() -> None:
    """Remove the folders of actors that were ended before they could do so."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_prefix()}*"):
        match = re.match(rf"{re.escape(_prefix())}(\d+)-", folder.name)
        if match and not Path("/proc", match[1]).exists() and Path("/proc/self").exists():
            shutil.rmtree(folder, ignore_errors=True)
