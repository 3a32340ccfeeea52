"""Starts a planner's process, watches its memory, bounds what it prints, and ends all it started.

Runs as a script between a worker and the planner, which have pipes to each other: nothing passes
through here but what the planner prints. It ends when the worker closes its pipe or dies, and then
kills the planner with all of its descendants, daemons included. Standard library only, since it
must start in no time:

    supervisor.py CONTROL STATUS MEMORY PRINTED COMMAND...

CONTROL and STATUS are file descriptors, MEMORY and PRINTED limits in bytes. One line is written to
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

PERIOD_MS = 20  # between two looks at the planner's memory
FAMILY_PERIOD = 0.25  # s between two looks at which processes it has started
SPARE_DATA = 1 << 30  # bytes that one process may ask for beyond its limit, at least
LAST_WORDS = b"\n[the planner has printed more than is kept: the rest is dropped]\n"
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # linux/prctl.h
CHUNK = 65_536


def main(arguments: list[str]) -> None:
    """Keep a planner until it or the worker ends."""
    control, status, memory, printed = (int(value) for value in arguments[:4])
    os.set_inheritable(control, False)
    os.set_inheritable(status, False)
    _prctl(PR_SET_CHILD_SUBREAPER, 1)  # what the planner's children leave behind stays ours
    signal.pthread_sigmask(signal.SIG_SETMASK, [])
    words, planner_words = os.pipe()
    planner = os.fork()
    if planner == 0:
        _become(arguments[4:], status, planner_words, memory)
    for descriptor in (0, 1, planner_words):
        os.close(descriptor)
    verdict = _Watch(planner, control, words, memory, printed).verdict()
    with contextlib.suppress(OSError):
        os.write(status, verdict.encode())
    end_descendants()


class _Watch:
    """One planner while it runs; changes with all it prints and starts."""

    def __init__(self, planner: int, control: int, words: int, memory: int, printed: int) -> None:
        self._planner = planner
        self._control = control
        self._words = words
        self._memory = memory
        self._printed = printed
        self._family = {planner}
        self._next_family = 0.0
        self._poll = select.poll()
        self._poll.register(control, select.POLLIN)
        self._poll.register(words, select.POLLIN)

    def verdict(self) -> str:
        """Wait for the end, and return what it was; nothing where the worker wants it."""
        while True:
            ready = dict(self._poll.poll(PERIOD_MS))
            if self._words in ready:
                self._pass_on()
            ended, state = os.waitpid(self._planner, os.WNOHANG)
            if ended:
                self._pass_on_the_rest()
                return _told(state)
            if self._held() > self._memory:
                return "memory\n"
            if self._control in ready:
                return ""

    def _held(self) -> int:
        """Return the bytes of memory that the planner's processes hold now."""
        now = time.monotonic()
        if now >= self._next_family:
            self._next_family = now + FAMILY_PERIOD
            self._family = {self._planner, *descendants()}
        return sum(map(resident, self._family))

    def _pass_on(self) -> bool:
        """Copy what was printed, as long as there is room for it; say whether there was any."""
        text = os.read(self._words, CHUNK)
        if not text:
            self._poll.unregister(self._words)
        elif self._printed > 0:
            kept = text[: self._printed]
            self._printed -= len(kept)
            _print(kept if self._printed > 0 else kept + LAST_WORDS)
        return bool(text)

    def _pass_on_the_rest(self) -> None:
        os.set_blocking(self._words, False)
        with contextlib.suppress(BlockingIOError, KeyError):
            while self._printed > 0 and self._pass_on():
                pass


def _become(command: list[str], status: int, words: int, memory: int) -> None:
    """Turn this process into the planner; it dies with the supervisor."""
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
    os.dup2(words, 2)
    try:
        os.execvp(command[0], command)  # the user's own command
    except OSError as error:
        os.write(status, f"unstartable {error.strerror}\n".encode())
        os._exit(127)


def descendants() -> set[int]:
    """Return this process's descendants; they cannot leave, since it is their subreaper."""
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
    """Return the bytes of memory a process holds; none where it has ended."""
    try:
        with open(f"/proc/{process}/statm", "rb") as file:  # noqa: PTH123  50 times a second
            return int(file.read().split()[1]) * resource.getpagesize()
    except (OSError, IndexError, ValueError):
        return 0


def end_descendants(patience: float = 5.0) -> None:
    """Kill all descendants, and those they start meanwhile."""
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


def _told(state: int) -> str:
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
    """Ask Linux for something; elsewhere there is no such thing."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


if __name__ == "__main__":
    main(sys.argv[1:])
