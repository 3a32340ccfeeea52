"""Supervises a planner's process: limits its memory and output, and ends all its descendants.

It is a script between a worker and the planner, which are connected by pipes: only the
planner's output passes through here. It ends when the worker closes its pipe or dies, and then
kills the planner with all of its descendants, daemons included. Standard library only, so that it
starts quickly. Usage:

    supervisor.py CONTROL STATUS MEMORY OUTPUT COMMAND...

CONTROL and STATUS are file descriptors, MEMORY and OUTPUT limits in bytes. One line is written to
STATUS when the planner has ended: "exit CODE", "signal NUMBER", "memory", or "unstartable REASON".
"""

import contextlib
import ctypes
import os
import resource
import select
import signal
import sys
import time
from pathlib import Path

PERIOD_MS = 20  # between two checks of the planner's memory
SEARCH_PERIOD = 0.25  # s between two searches for the planner's descendants
SPARE_DATA = 1 << 30  # bytes, the minimum by which RLIMIT_DATA exceeds the memory limit
TRUNCATED = b"\n[the planner's output is too long: the rest is dropped]\n"
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # linux/prctl.h
CHUNK = 65_536


def main(arguments: list[str]) -> None:
    """Supervise a planner until it or the worker ends."""
    control, status, memory, output_limit = (int(value) for value in arguments[:4])
    os.set_inheritable(control, False)
    os.set_inheritable(status, False)
    _prctl(PR_SET_CHILD_SUBREAPER, 1)  # orphaned descendants become children of this process
    signal.pthread_sigmask(signal.SIG_SETMASK, [])
    output, planner_output = os.pipe()
    planner = os.fork()
    if planner == 0:
        _execute(arguments[4:], status, planner_output, memory)
    for descriptor in (0, 1, planner_output):
        os.close(descriptor)
    line = _Monitor(planner, control, output, memory, output_limit).wait()
    with contextlib.suppress(OSError):
        os.write(status, line.encode())
    end_descendants()


class _Monitor:
    """Monitors one running planner; mutable."""

    def __init__(
        self, planner: int, control: int, output: int, memory: int, output_limit: int
    ) -> None:
        self._planner = planner
        self._control = control
        self._output = output
        self._memory_limit = memory
        self._output_left = output_limit
        self._processes = {planner}
        self._next_search = 0.0
        self._poll = select.poll()
        self._poll.register(control, select.POLLIN)
        self._poll.register(output, select.POLLIN)

    def wait(self) -> str:
        """Wait for the end and return the status line; empty if the worker ends the planner."""
        while True:
            ready = dict(self._poll.poll(PERIOD_MS))
            if self._output in ready:
                self._copy_output()
            ended, state = os.waitpid(self._planner, os.WNOHANG)
            if ended:
                self._copy_remaining_output()
                return _status_line(state)
            if self._memory_in_use() > self._memory_limit:
                return "memory\n"
            if self._control in ready:
                return ""

    def _memory_in_use(self) -> int:
        """Return the resident memory of the planner's processes, bytes."""
        now = time.monotonic()
        if now >= self._next_search:
            self._next_search = now + SEARCH_PERIOD
            self._processes = {self._planner, *descendants()}
        return sum(map(resident, self._processes))

    def _copy_output(self) -> bool:
        """Copy output up to the limit; return whether there was any."""
        text = os.read(self._output, CHUNK)
        if not text:
            self._poll.unregister(self._output)
        elif self._output_left > 0:
            kept = text[: self._output_left]
            self._output_left -= len(kept)
            _print(kept if self._output_left > 0 else kept + TRUNCATED)
        return bool(text)

    def _copy_remaining_output(self) -> None:
        os.set_blocking(self._output, False)
        with contextlib.suppress(BlockingIOError, KeyError):
            while self._output_left > 0 and self._copy_output():
                pass


def _execute(command: list[str], status: int, output: int, memory: int) -> None:
    """Replace this process by the planner, which is killed when the supervisor ends."""
    _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    for number in (signal.SIGINT, signal.SIGPIPE, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    data = max(2 * memory, memory + SPARE_DATA)
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_DATA, (data, data))
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")
    os.dup2(output, 2)
    try:
        os.execvp(command[0], command)  # the user's own command
    except OSError as error:
        os.write(status, f"unstartable {error.strerror}\n".encode())
        os._exit(127)


def descendants() -> set[int]:
    """Return this process's descendants, including orphaned ones, since it is their subreaper."""
    children: dict[int, list[int]] = {}
    for name in _numbers("/proc"):
        with contextlib.suppress(OSError, IndexError, ValueError):
            stat = Path("/proc", name, "stat").read_bytes()
            parent = int(stat[stat.rindex(b")") + 2 :].split()[1])
            children.setdefault(parent, []).append(int(name))
    found: set[int] = set()
    waiting = [os.getpid()]
    while waiting:
        for child in children.get(waiting.pop(), ()):
            if child not in found:
                found.add(child)
                waiting.append(child)
    return found


def resident(process: int) -> int:
    """Return a process's resident memory, bytes; 0 if it has ended."""
    try:
        with open(f"/proc/{process}/statm", "rb") as file:  # noqa: PTH123  50 times a second
            return int(file.read().split()[1]) * resource.getpagesize()
    except (OSError, IndexError, ValueError):
        return 0


def end_descendants(patience: float = 5.0) -> None:
    """Kill all descendants, including any that are started meanwhile."""
    deadline = time.monotonic() + patience
    while time.monotonic() < deadline:
        for process in descendants():
            with contextlib.suppress(OSError):
                os.kill(process, signal.SIGKILL)
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        time.sleep(0.002)


def _status_line(state: int) -> str:
    if os.WIFSIGNALED(state):
        return f"signal {os.WTERMSIG(state)}\n"
    return f"exit {os.WEXITSTATUS(state)}\n"


def _print(text: bytes) -> None:
    with contextlib.suppress(OSError):
        os.write(2, text)


def _numbers(folder: str) -> list[str]:
    try:
        return [name for name in os.listdir(folder) if name.isdecimal()]  # noqa: PTH208
    except OSError:
        return []


def _prctl(option: int, value: int) -> None:
    """Call prctl on Linux; do nothing on other systems."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


if __name__ == "__main__":
    main(sys.argv[1:])
