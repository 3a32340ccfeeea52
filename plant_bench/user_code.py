"""Runs the code of users' planners: contains its side effects, and says where it has failed."""

import os
import re
import sysconfig
import threading
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import thread as thread_pools
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn

from plant_bench.errors import LONGEST, InputError, UserCodeError
from plant_bench.text_escaping import one_line

PLANNER_LOG = "PLANT_BENCH_PLANNER_LOG"  # variable: file to which tracebacks are appended

_ADDRESS = re.compile(r"\b0x[0-9a-fA-F]+")
_PACKAGE = Path(__file__).resolve().parent
_AGENTS = _PACKAGE / "agents"
_CALLERS = (_AGENTS / "loading", _AGENTS / "remote")  # they call planners, and are none
_STANDARD_LIBRARY = Path(sysconfig.get_path("stdlib"))
_INSTALLED = ("site-packages", "dist-packages")
_USER = "."
_CHILDREN_REFUSED = "daemonic processes are not allowed to have children"
_lock = threading.RLock()  # `contained` replaces functions of the whole process


@contextmanager
def contained() -> Iterator[None]:
    """Run users' code in the context without lasting effects on this process.

    The working folder is restored. Threads that the code starts are daemons, so that they do not
    keep the process alive. `os._exit` raises SystemExit.
    """
    with _lock:
        folder = working_folder()
        start, leave = threading.Thread.start, os._exit
        started: list[threading.Thread] = []

        def start_daemon(self: threading.Thread) -> None:
            with suppress(RuntimeError):  # it has already been started, as `start` will say
                self.daemon = True
            started.append(self)
            start(self)

        threading.Thread.start = start_daemon
        os._exit = _exit_function(leave)
        try:
            yield
        finally:
            threading.Thread.start, os._exit = start, leave
            for thread in started:  # Python waits for the threads of pools, although daemons
                getattr(thread_pools, "_threads_queues", {}).pop(thread, None)
            if folder is not None:
                os.chdir(folder)


def _exit_function(leave: Callable[[int], NoReturn]) -> Callable[[int], NoReturn]:
    process = os.getpid()

    def exit_by_exception(code: int) -> NoReturn:
        if os.getpid() != process:  # a forked child
            leave(code)
        message = f"os._exit({code})"
        raise SystemExit(message)

    return exit_by_exception


def working_folder() -> str | None:
    """Return the working folder; None if it has been removed."""
    try:
        return os.getcwd()  # noqa: PTH109
    except OSError:
        return None


@contextmanager
def planner_log(path: Path) -> Iterator[None]:
    """Append tracebacks of planners' code to a file; the message of an `InputError` names it.

    The file is written only if there is a traceback. Processes started in the context append to it,
    too.

    Raises:
        InputError: Raised in the context.
    """
    before, size = os.environ.get(PLANNER_LOG), _size(path)
    os.environ[PLANNER_LOG] = str(path.absolute())
    try:
        yield
    except InputError as error:
        if _size(path) > size:
            raise InputError(with_log(str(error), path)) from error
        raise
    finally:
        if before is None:
            os.environ.pop(PLANNER_LOG)
        else:
            os.environ[PLANNER_LOG] = before


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def with_log(message: str, path: Path) -> str:
    """Return a message that also names the log of the failure.

    >>> with_log("It failed (mine.py:3)", Path("logs/worker0.log"))
    'It failed (mine.py:3). Log: logs/worker0.log'
    """
    return f"{message.removesuffix('.')}. Log: {path}"


def log_traceback(error: BaseException) -> None:
    """Append the traceback of a planner's exception to the log (`planner_log`), if there is one."""
    name = os.environ.get(PLANNER_LOG)
    if not name:
        return
    with suppress(Exception):  # the exception's text may be the planner's own code
        text = "".join(traceback.format_exception(error))
        path = Path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a", encoding="utf-8", errors="replace") as log:
            log.write(text)


def loading_error(what: str, error: BaseException, hint: str = "") -> InputError:
    """Return the error to raise because loading or creating a planner has raised an exception.

    Its traceback is logged if the planner's own code was running.

    Args:
        what: What failed, such as "The agent 'mine.py:Mine' cannot be created".
        error: The exception.
        hint: Appended to the message.
    """
    message = f"{what}: {type(error).__name__}: {located_text(error)}{hint}"
    if not code_location(error):
        return InputError(message)
    log_traceback(error)
    return UserCodeError(message)


def located_text(error: BaseException) -> str:
    r"""Return an exception's text as one line of bounded length, with its place at the end.

    It does not depend on the machine: memory addresses are left out.

    >>> located_text(ValueError("no\nlane at 0x7f12ab"))
    'no lane at 0x...'
    """
    failed = error.__cause__ if isinstance(error, UserCodeError) else error
    place = "" if failed is None else code_location(failed)
    ending = f" ({place})" if place else ""
    text = " ".join(_ADDRESS.sub("0x...", _own_text(error)).split()).removesuffix(ending)
    text = one_line(text, LONGEST, instead="?")
    if len(text) + len(ending) > LONGEST:
        text = one_line(text.removesuffix("..."), max(LONGEST - len(ending) - 3, 0), instead="?")
    return (text + ending).lstrip()


def _own_text(error: BaseException) -> str:
    try:
        text = error.msg if isinstance(error, SyntaxError) else str(error)
    except Exception:  # noqa: BLE001  __str__ is the planner's code, too
        return "no text"
    if _CHILDREN_REFUSED in text:
        return f"{text}; `plant-bench score --isolate` allows them"
    return text


def code_location(error: BaseException) -> str:
    """Return the innermost line of a planner's own code in a traceback as "file.py:LINE".

    That is code of neither plant-bench, nor the standard library, nor an installed package. If
    there is none, because the planner itself is built in or installed, it is the innermost line of
    the planner's package. Empty if no planner's code was running.
    """
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        return f"{Path(error.filename).name}:{error.lineno}"
    frames = [
        (Path(frame.f_code.co_filename), line)
        for frame, line in traceback.walk_tb(error.__traceback__)
    ]
    origins = [_origin(path) for path, _ in frames]
    own = _USER if _USER in origins else next(filter(None, origins), "")
    places = [frame for frame, origin in zip(frames, origins, strict=True) if own and origin == own]
    return f"{places[-1][0].name}:{places[-1][1]}" if places else ""


def _origin(path: Path) -> str:
    """Return whose code a file is: `_USER`, or the name of a package; empty for callers."""
    if path.is_relative_to(_PACKAGE):
        is_planner = path.is_relative_to(_AGENTS) and not any(map(path.is_relative_to, _CALLERS))
        return _PACKAGE.name if is_planner else ""
    for index, part in enumerate(path.parts[:-1]):
        if part in _INSTALLED:
            return path.parts[index + 1].removesuffix(".py")
    is_generated = path.name.startswith("<")
    return "" if is_generated or path.is_relative_to(_STANDARD_LIBRARY) else _USER


def call_reported(method: Callable[..., Any], *arguments: object) -> Any:
    """Call a planner's method; log its exceptions, and raise them again with their place.

    Raises:
        Exception: Of the same name, whose text is `located_text`.
    """
    try:
        return method(*arguments)
    except (Exception, SystemExit) as error:
        log_traceback(error)
        raise type(type(error).__name__, (Exception,), {})(located_text(error)) from error
