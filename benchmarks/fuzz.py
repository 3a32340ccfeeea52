"""Fuzzer: feeds broken files to every loader; each must return the object or raise InputError.

    python benchmarks/fuzz.py --minutes 10 --formats all

A child process with limited memory reads mutated files: bytes are flipped, cut, duplicated and
inserted; in structured formats, values are also replaced by problematic ones. The parent process
detects children that hang or die. An audit hook detects files written outside the case's folder,
unpickling, processes and connections; only map imports may start SUMO's programs. Files that those
write are searched for in the case's folder and where paths in broken files point. Failed cases are
written to --keep; the exit code is then 1.
"""

import argparse
import contextlib
import multiprocessing
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.context import ForkProcess
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import sumo
from fuzzing.form import Format
from fuzzing.formats import FORMATS
from fuzzing.mutations import mutated

from plant_bench.errors import PlantBenchError

MEMORY = 4_000_000_000  # bytes that a child may allocate after its start
START = 120.0  # s of extra time for the first case, since imports are slow on a busy machine
FORBIDDEN = ("pickle.find_class", "os.system", "os.exec", "os.posix_spawn", "socket.connect")
SCRATCH = "scratch"  # folder for the loaders' temporary files, in the case's folder
ESCAPED = "fuzz-escaped"  # the file to which paths and commands in broken files point


@dataclass
class Count:
    """Counts of the cases of a format; mutable."""

    cases: int = 0
    accepted: int = 0
    failed: int = 0


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--formats", default="all", help=f"some of {', '.join(FORMATS)}")
    parser.add_argument("--minutes", type=float, default=10.0, help="time per format")
    parser.add_argument("--cases", type=int, default=0, help="maximum per format; 0 for no limit")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-failures"))
    arguments = parser.parse_args()
    names = list(FORMATS) if arguments.formats == "all" else arguments.formats.split(",")
    bad = 0
    for name in names:
        began = time.monotonic()
        count = fuzz(FORMATS[name], arguments)
        bad += count.failed
        minutes = (time.monotonic() - began) / 60.0
        print(
            f"{name:12s} {minutes:5.1f} min {count.cases:8d} cases, {count.accepted} accepted, "
            f"{count.failed} failed",
            flush=True,
        )
    sys.exit(1 if bad else 0)


def fuzz(target: Format, arguments: argparse.Namespace) -> Count:
    """Fuzz one loader; a child process that dies is replaced by a new one."""
    context = multiprocessing.get_context("fork")
    end = time.monotonic() + 60.0 * arguments.minutes
    count, seed = Count(), arguments.seed
    while time.monotonic() < end and (not arguments.cases or count.cases < arguments.cases):
        with tempfile.TemporaryDirectory(prefix="fuzz-") as folder:
            cases, accepted, failed, heartbeat = (
                context.Value("l"),
                context.Value("l"),
                context.Value("l"),
                context.Value("d", time.monotonic() + START),
            )
            left = arguments.cases - count.cases if arguments.cases else 0
            shared = (cases, accepted, failed, heartbeat)
            child = context.Process(
                target=_child, args=(target, Path(folder), seed, end, left, arguments.keep, shared)
            )
            child.start()
            try:
                reason = _wait(child, heartbeat, target.longest)
            finally:
                _end(child)
            if reason:
                _keep(Path(folder) / target.file, arguments.keep, target, seed, reason)
                failed.value += 1
            count.cases += cases.value
            count.accepted += accepted.value
            count.failed += failed.value
        seed += 1_000_003
    return count


def _wait(child: ForkProcess, heartbeat: Synchronized, longest: float) -> str:
    """Wait for a child; return how it failed, or an empty string."""
    while child.is_alive():
        child.join(0.5)
        if time.monotonic() - heartbeat.value > longest:
            return "hangs"
    return f"died {child.exitcode}" if child.exitcode else ""


def _end(child: ForkProcess) -> None:
    """Kill a child and the processes that it has started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid or 0, signal.SIGKILL)
    child.kill()
    child.join()


def _child(
    target: Format,
    folder: Path,
    seed: int,
    end: float,
    most: int,
    keep: Path,
    shared: tuple[Synchronized, ...],
) -> None:
    cases, accepted, failed, heartbeat = shared
    keep = keep.resolve()
    os.setpgid(0, 0)
    parent = os.getppid()
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    warnings.simplefilter("ignore")
    seeds = target.seeds()
    file = folder / target.file
    file.parent.mkdir(parents=True, exist_ok=True)
    target.prepare(folder)
    (folder / SCRATCH).mkdir()
    tempfile.tempdir = str(folder / SCRATCH)
    os.chdir(folder / SCRATCH)
    for content in seeds:  # valid files: loading them also imports lazily loaded modules
        file.write_bytes(content)
        target.load(folder)
    guard = _Guard(folder, target.programs)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = used * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    rng = random.Random(seed)
    while time.monotonic() < end and (not most or cases.value < most) and os.getppid() == parent:
        content = mutated(rng, seeds, target.kind)
        file.write_bytes(content)
        heartbeat.value = time.monotonic()
        fault = guard.watch(target.load)
        if fault is None:
            accepted.value += 1
        elif fault:
            failed.value += 1
            _keep(file, keep, target, seed, fault)
        cases.value += 1
    os._exit(0)


class _Guard:
    """Detects forbidden actions of a loader; mutable."""

    def __init__(self, folder: Path, programs: frozenset[str]) -> None:
        self._folder, self._on, self._seen = str(folder), False, ""
        self._programs = {os.path.join(sumo.SUMO_HOME, "bin", name) for name in programs}  # noqa: PTH118
        sys.addaudithook(self._audit)

    def watch(self, load: Callable[[Path], object]) -> str | None:
        """Load the file; return None if it was accepted, "" if it was rejected, or the failure."""
        self._on, self._seen = True, ""
        try:
            load(Path(self._folder))
            found = None
        except PlantBenchError as error:
            found = "" if "\n" not in str(error) else f"several lines: {error}"
        except BaseException:  # noqa: BLE001  any other exception is a failure
            found = traceback.format_exc()
        finally:
            self._on = False
        return self._seen or self._left_behind() or found

    def _left_behind(self) -> str:
        """Return and remove files that a case has left where there should be none."""
        scratch = Path(self._folder) / SCRATCH
        places = [scratch, *scratch.parents, Path.home()]
        escaped = [path for place in places if (path := place / ESCAPED).exists()]
        left = [*scratch.iterdir(), *escaped]
        for path in left:
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        return f"leaves {', '.join(map(str, left))}" if left else ""

    def _audit(self, event: str, arguments: tuple) -> None:
        if not self._on:
            return
        started = event == "subprocess.Popen" and arguments[0] not in self._programs
        if started or event.startswith(FORBIDDEN):
            self._seen = f"{event} {arguments}"
        elif event == "open" and isinstance(arguments[0], str | bytes):
            path, _, flags = arguments
            writes = isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            inside = os.fsdecode(path).startswith((self._folder, os.devnull, "/proc/self"))
            if writes and not inside and os.fsdecode(path).startswith(os.sep):
                self._seen = f"writes {os.fsdecode(path)}"


def _keep(file: Path, keep: Path, target: Format, seed: int, reason: str) -> None:
    keep.mkdir(parents=True, exist_ok=True)
    number = len(list(keep.glob(f"{target.name}-*.reason")))
    if number >= 50:  # enough per format: further ones are usually duplicates
        return
    stem = keep / f"{target.name}-{number:03d}"
    stem.with_suffix(".case").write_bytes(file.read_bytes() if file.is_file() else b"")
    stem.with_suffix(".reason").write_text(f"seed {seed}\n{reason}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
