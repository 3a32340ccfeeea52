"""Ray actor that supervises one worker process on a node.

Simulator and planner run in a separate process, as in a local run, not in the actor. Their crash
can thus be distinguished from the loss of the node and is reported as in a local run. The process
is also needed because libsumo supports one simulation per process. This module does not import Ray.
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
    activate,
    check_payload,
    differences,
    environment,
    unpack,
)
from plant_bench.runner.workers.process_start import start_process
from plant_bench.runner.workers.worker import (
    Failed,
    Message,
    Progress,
    Ready,
    Report,
    Work,
    exit_failure,
    serve,
)

REPLY_TIMEOUT = 1.0  # s that one call waits for a message
START_TIMEOUT = 120.0  # s for a worker process to start
LOG_CHUNK = 2**20  # bytes of the worker's log per reply


@dataclass(frozen=True)
class Refusal:
    """The node cannot be used."""

    reason: str


@dataclass(frozen=True)
class TaskOutput:
    """A task's return value, and the content of its files by their paths in the run's folder."""

    value: Any
    files: Mapping[str, bytes] = field(repr=False)


@dataclass(frozen=True)
class ActorReply:
    """Reply of an actor: the worker's last message, and its output since the last reply."""

    message: Message | Refusal | None
    output: bytes = b""


class NodeWorker:
    """One worker process and its working folder; mutable."""

    def __init__(self, local_environment: Mapping[str, str] | None = None) -> None:
        _remove_stale_folders()
        self._folder = Path(tempfile.mkdtemp(prefix=f"{_prefix()}{os.getpid()}-"))
        self._paths = NodePaths(self._folder / "files", self._folder / "output")
        self._log = self._folder / "worker.log"
        self._environment = environment() if local_environment is None else local_environment
        self._log_read = 0
        self._process: tuple[Any, Connection] | None = None

    def start(self, payload: Payload, work: Work) -> ActorReply:
        """Unpack the payload and start the worker; reply `Ready` or `Refusal`."""
        unequal = differences(payload.environment, self._environment)
        if unequal:
            return ActorReply(Refusal(unequal))
        self._payload, self._work = payload, work
        try:
            unpack(payload, self._paths)
            self._start_process()
        except (PlantBenchError, OSError) as error:
            return ActorReply(Refusal(str(error)))
        message = self._next_message(START_TIMEOUT)
        if isinstance(message, Ready):
            return ActorReply(message, self._new_output())
        reason = message.reason if isinstance(message, Failed) else "The worker does not start."
        return ActorReply(Refusal(reason), self._new_output())

    def step(self, task: Portable | None) -> ActorReply:
        """Send the worker a task, if any; reply with its next message, or None if there is none."""
        if task is not None:
            if self._process is None:
                self._start_process()
                first = self._next_message(START_TIMEOUT)
                if not isinstance(first, Ready):
                    self._kill_process()
                    timeout = Failed("The worker does not start.")
                    return ActorReply(
                        first if isinstance(first, Failed) else timeout, self._new_output()
                    )
            self._send(task)
        message = self._next_message(REPLY_TIMEOUT)
        if isinstance(message, Failed):
            self._kill_process()  # the failure may have left the simulator in an invalid state
        return ActorReply(message, self._new_output())

    def close(self) -> None:
        """Kill the worker and remove its folder."""
        self._kill_process()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _start_process(self) -> None:
        main = sys.modules["__main__"]
        vars(main).pop("__file__", None)  # else the child would import Ray's main module
        main.__spec__ = None
        arguments = (self._payload, self._paths, self._work, self._log)
        self._process = start_process(_serve_on_node, *arguments)

    def _send(self, task: Portable) -> None:
        assert self._process is not None  # noqa: S101
        try:
            self._process[1].send(task)
        except OSError:
            return  # a dead worker is handled when its pipe is read

    def _next_message(self, timeout: float) -> Message | None:
        """Return the next message other than `Progress`, or at the timeout the latest progress."""
        if self._process is None:
            return None
        process, pipe = self._process
        message: Message | None = None
        deadline = time.monotonic() + timeout
        try:
            while pipe.poll(max(deadline - time.monotonic(), 0.0)):
                message = pipe.recv()
                if not isinstance(message, Progress):
                    break
        except (EOFError, OSError):
            process.join()
            self._kill_process()
            message = exit_failure(process.exitcode or 0)
        return message

    def _kill_process(self) -> None:
        if self._process is not None:
            process, pipe = self._process
            process.kill()
            process.join()
            pipe.close()
            self._process = None
        shutil.rmtree(self._paths.output, ignore_errors=True)
        self._paths.output.mkdir(parents=True, exist_ok=True)

    def _new_output(self) -> bytes:
        if not self._log.is_file():
            return b""
        with self._log.open("rb") as file:
            file.seek(self._log_read)
            output = file.read(LOG_CHUNK)
        self._log_read += len(output)
        return output


def _serve_on_node(
    pipe: Connection, payload: Payload, paths: NodePaths, work: Work, log: Path
) -> None:
    """Activate the payload and run tasks: the main function of a worker process on a node."""
    paths = activate(payload, paths)
    try:
        check_payload(payload, paths)
    except (PlantBenchError, OSError) as error:
        traceback.print_exc()
        pipe.send(Failed(str(error), fatal=True))
        return
    serve(pipe, partial(_run_task_on_node, work, paths), log)


def _run_task_on_node(work: Work, paths: NodePaths, task: Portable, report: Report) -> TaskOutput:
    """Run a task with this node's paths; return its value and the files it has written."""
    value = work(task.with_paths(paths), report)
    written = sorted(path for path in paths.output.rglob("*") if path.is_file())
    files = {path.relative_to(paths.output).as_posix(): path.read_bytes() for path in written}
    for path in written:
        path.unlink()
    return TaskOutput(value, files)


def _prefix() -> str:
    return f"plant-bench-{os.getuid()}-"


def _remove_stale_folders() -> None:
    """Remove the folders of actors that were killed before they could remove them."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_prefix()}*"):
        match = re.match(rf"{re.escape(_prefix())}(\d+)-", folder.name)
        if match and not Path("/proc", match[1]).exists() and Path("/proc/self").exists():
            shutil.rmtree(folder, ignore_errors=True)
