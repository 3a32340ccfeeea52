"""The client side of a planner's process: sends requests, enforces limits, reports why it ended."""

import contextlib
import os
import select
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agents.remote.remote_errors import (
    MemoryLimitError,
    ProcessEndedError,
    ProtocolError,
    RemoteError,
    TimeLimitError,
)
from plant_bench.errors import InputError

GIGABYTE = 1_000_000_000
LENGTH = struct.Struct("<I")  # before each message: its length in bytes
LONGEST_RESPONSE = 1 << 20  # bytes
OUTPUT_LIMIT = 262_144  # bytes of a planner's output that are printed
GRACE = 2.0  # s for the supervisor to report why a planner has closed its pipe
CLOSING = 10.0  # s for the supervisor to end all processes that the planner started
CHUNK = 1 << 16
_SUPERVISOR = str(Path(__file__).with_name("supervisor.py"))


@dataclass(frozen=True)
class Limits:
    """Time and memory limits of a planner's process.

    Attributes:
        tick: Wall time for one decision, seconds.
        start_up: Wall time to start, and for each `reset`, seconds.
        memory: Total resident memory of all of its processes, gigabytes.
    """

    tick: float = 5.0
    start_up: float = 120.0
    memory: float = 4.0

    def __post_init__(self) -> None:
        """Check that all are positive.

        Raises:
            InputError: One is not.
        """
        for name, value in vars(self).items():
            if not 0.0 < value < 1e6:
                option = f"--{name.replace('_', '-')}-limit"
                message = f"{option}: expected a number above 0 and below 1e6, got {value:g}."
                raise InputError(message)


class PlannerProcess:
    """A planner's process with its supervisor; mutable.

    Args:
        command: The command to start; it speaks the protocol on standard input and output.
        limits: Its time and memory limits.

    Raises:
        InputError: The system is not Linux, which is required to find and end its processes.
        OSError: It cannot be started.
    """

    def __init__(self, command: Sequence[str], limits: Limits) -> None:
        if not sys.platform.startswith("linux"):
            message = "Planners in separate processes (--isolate, command:) require Linux."
            raise InputError(message)
        self.limits = limits
        control, self._control = os.pipe()
        self._status, status = os.pipe()
        memory = int(limits.memory * GIGABYTE)
        options = (str(control), str(status), str(memory), str(OUTPUT_LIMIT))
        self._supervisor = subprocess.Popen(
            [sys.executable, "-I", "-S", _SUPERVISOR, *options, *command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(control, status),
            start_new_session=True,  # so that Ctrl-C reaches the parent only
            bufsize=0,
        )
        os.close(control)
        os.close(status)
        stdin, stdout = self._supervisor.stdin, self._supervisor.stdout
        if stdin is None or stdout is None:  # impossible: both are pipes
            raise RuntimeError
        self._to, self._from = stdin.fileno(), stdout.fileno()
        os.set_blocking(self._to, False)
        os.set_blocking(self._from, False)
        self.alive = True

    def ask(self, message: bytes, seconds: float, limit: str) -> bytes:
        """Send a request and return the response; end the process if it fails.

        Args:
            message: The request.
            seconds: Time limit for the response.
            limit: The option that sets the limit, for the error message.

        Raises:
            RemoteError: The process did not respond as it should.
        """
        if not self.alive:
            message_ = "its process has already been ended."
            raise ProcessEndedError(message_)
        try:
            return self._exchange(LENGTH.pack(len(message)) + message, seconds, limit)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """End the process and all processes that it started."""
        if not self.alive:
            return
        self.alive = False
        os.close(self._control)
        try:
            self._supervisor.wait(CLOSING)
        except subprocess.TimeoutExpired:
            self._supervisor.kill()
            self._supervisor.wait()
        for stream in (self._supervisor.stdin, self._supervisor.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        os.close(self._status)

    def _exchange(self, frame: bytes, seconds: float, limit: str) -> bytes:
        deadline = time.monotonic() + seconds
        self._expect_silence()
        left, response = memoryview(frame), bytearray()
        poll = select.poll()
        poll.register(self._from, select.POLLIN)
        poll.register(self._to, select.POLLOUT)
        while (size := _size(response)) is None or len(response) < size:
            wait = deadline - time.monotonic()
            events = dict(poll.poll(1000.0 * wait)) if wait > 0.0 else {}
            if not events:
                message = f"no response within {seconds:g} s ({limit})."
                raise TimeLimitError(message)
            if self._to in events:
                left = self._send(left)
                if not left:
                    poll.unregister(self._to)
            if self._from in events:
                response += self._receive()
        if len(response) > size or left:
            message = "it sent more than one response, or sent before the request."
            raise ProtocolError(message)
        return bytes(response[LENGTH.size :])

    def _send(self, left: memoryview) -> memoryview:
        try:
            return left[os.write(self._to, left) :]
        except BlockingIOError:
            return left
        except OSError:
            raise self._end() from None

    def _receive(self) -> bytes:
        try:
            text = os.read(self._from, CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            text = b""
        if not text:
            raise self._end()
        return text

    def _expect_silence(self) -> None:
        with contextlib.suppress(BlockingIOError):
            if os.read(self._from, 1):
                message = "it sent a message without a request."
                raise ProtocolError(message)
            raise self._end()

    def _end(self) -> RemoteError:
        """Return the error that says why a planner's pipe is closed."""
        if not select.select([self._status], [], [], GRACE)[0]:
            return ProcessEndedError("it has closed its pipe.")
        status = os.read(self._status, CHUNK).decode(errors="replace").partition("\n")[0]
        kind, _, rest = status.partition(" ")
        if kind == "memory":
            return memory_limit(self.limits)
        if kind == "signal":
            return ProcessEndedError(f"its process was ended by {_signal_name(rest)}.")
        if kind == "exit":
            return ProcessEndedError(f"its process ended with exit code {rest}.")
        if kind == "unstartable":
            return ProcessEndedError(f"it cannot be started: {rest}.")
        return ProcessEndedError("its process and its supervisor have ended.")


def memory_limit(limits: Limits) -> MemoryLimitError:
    """Return the error of a planner that exceeds its memory limit."""
    return MemoryLimitError(f"it uses more than {limits.memory:g} GB (--memory-limit).")


def _size(response: bytearray) -> int | None:
    """Return the total size of the message being received; None while unknown.

    Raises:
        ProtocolError: The message is too long.
    """
    if len(response) < LENGTH.size:
        return None
    (length,) = LENGTH.unpack_from(response)
    if length > LONGEST_RESPONSE:
        message = f"it announced a message of more than {LONGEST_RESPONSE} bytes."
        raise ProtocolError(message)
    return LENGTH.size + length


def _signal_name(number: str) -> str:
    try:
        return signal.Signals(int(number)).name
    except ValueError:
        return f"signal {number}"
