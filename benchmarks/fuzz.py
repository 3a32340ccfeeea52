"""Fuzzer: feeds broken files to every loader; each must return the object or raise InputError.

    python benchmarks/fuzz.py --minutes 10 --formats all

A child process with little memory reads mutated files: bytes flipped, cut, doubled and inserted;
where a file has a structure also values replaced by what is likely to hurt. The parent watches for
what a child cannot tell: that it hangs, or dies. An audit hook watches for files written outside of
the case's folder, for pickles, for processes and for connections; imported maps alone may start
SUMO's programs. What those write is watched by looking: at the case's folder, and where paths in
broken files lead. Cases that fail are kept in --keep. Exit code 1 if there are any.
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

MEMORY = 4_000_000_000  # bytes a child may have beyond what it has at its start
START = 120.0  # s more until the first: what a loader imports takes long on a busy machine
FORBIDDEN = ("pickle.find_class", "os.system", "os.exec", "os.posix_spawn", "socket.connect")
SCRATCH = "scratch"  # in a case's folder: what loaders put into the system's folder for such
ESCAPED = "fuzz-escaped"  # the file that paths and commands in broken files lead to


@dataclass
class Count:
    """What became of a format's cases; mutable."""

    cases: int = 0
    accepted: int = 0
    failed: int = 0


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--formats", default="all", help=f"of {', '.join(FORMATS)}")
    parser.add_argument("--minutes", type=float, default=10.0, help="a format")
    parser.add_argument("--cases", type=int, default=0, help="a format; 0 for as many as go")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-failures"))
    given = parser.parse_args()
    names = list(FORMATS) if given.formats == "all" else given.formats.split(",")
    bad = 0
    for name in names:
        began = time.monotonic()
        count = fuzz(FORMATS[name], given)
        bad += count.failed
        minutes = (time.monotonic() - began) / 60.0
        print(
            f"{name:12s} {minutes:5.1f} min {count.cases:8d} cases, {count.accepted} accepted, "
            f"{count.failed} failed",
            flush=True,
        )
    sys.exit(1 if bad else 0)


def fuzz(target: Format, given: argparse.Namespace) -> Count:
    """Feed one loader, in as many children as die."""
    context = multiprocessing.get_context("fork")
    end = time.monotonic() + 60.0 * given.minutes
    count, seed = Count(), given.seed
    while time.monotonic() < end and (not given.cases or count.cases < given.cases):
        with tempfile.TemporaryDirectory(prefix="fuzz-") as box:
            cases, accepted, failed, beat = (
                context.Value("l"),
                context.Value("l"),
                context.Value("l"),
                context.Value("d", time.monotonic() + START),
            )
            left = given.cases - count.cases if given.cases else 0
            facts = (cases, accepted, failed, beat)
            child = context.Process(
                target=_child, args=(target, Path(box), seed, end, left, given.keep, facts)
            )
            child.start()
            try:
                why = _wait(child, beat, target.longest)
            finally:
                _end(child)
            if why:
                _keep(Path(box) / target.file, given.keep, target, seed, why)
                failed.value += 1
            count.cases += cases.value
            count.accepted += accepted.value
            count.failed += failed.value
        seed += 1_000_003
    return count


def _wait(child: ForkProcess, beat: Synchronized, longest: float) -> str:
    """Wait for a child; return why it did not end as it should, or an empty text."""
    while child.is_alive():
        child.join(0.5)
        if time.monotonic() - beat.value > longest:
            return "hangs"
    return f"died {child.exitcode}" if child.exitcode else ""


def _end(child: ForkProcess) -> None:
    """End a child and what it has started, also where this process is interrupted."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid or 0, signal.SIGKILL)
    child.kill()
    child.join()


def _child(
    target: Format,
    box: Path,
    seed: int,
    end: float,
    most: int,
    keep: Path,
    facts: tuple[Synchronized, ...],
) -> None:
    cases, accepted, failed, beat = facts
    keep = keep.resolve()
    os.setpgid(0, 0)
    parent = os.getppid()
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    warnings.simplefilter("ignore")
    seeds = target.seeds()
    file = box / target.file
    file.parent.mkdir(parents=True, exist_ok=True)
    target.prepare(box)
    (box / SCRATCH).mkdir()
    tempfile.tempdir = str(box / SCRATCH)
    os.chdir(box / SCRATCH)
    for content in seeds:  # they load, and warm up what is loaded late
        file.write_bytes(content)
        target.load(box)
    guard = _Guard(box, target.programs)
    used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = used * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    chance = random.Random(seed)
    while time.monotonic() < end and (not most or cases.value < most) and os.getppid() == parent:
        content = mutated(chance, seeds, target.kind)
        file.write_bytes(content)
        beat.value = time.monotonic()
        fault = guard.watch(target.load)
        if fault is None:
            accepted.value += 1
        elif fault:
            failed.value += 1
            _keep(file, keep, target, seed, fault)
        cases.value += 1
    os._exit(0)


class _Guard:
    """Watches what a loader does; mutable."""

    def __init__(self, box: Path, programs: frozenset[str]) -> None:
        self._box, self._on, self._seen = str(box), False, ""
        self._programs = {os.path.join(sumo.SUMO_HOME, "bin", name) for name in programs}  # noqa: PTH118
        sys.addaudithook(self._hear)

    def watch(self, load: Callable[[Path], object]) -> str | None:
        """Return None where the file was accepted, "" where it was refused, or what went wrong."""
        self._on, self._seen = True, ""
        try:
            load(Path(self._box))
            found = None
        except PlantBenchError as error:
            found = "" if "\n" not in str(error) else f"several lines: {error}"
        except BaseException:  # noqa: BLE001  that is what is looked for
            found = traceback.format_exc()
        finally:
            self._on = False
        return self._seen or self._left_behind() or found

    def _left_behind(self) -> str:
        """Tell what a case has left where nothing should be, and remove it."""
        scratch = Path(self._box) / SCRATCH
        places = [scratch, *scratch.parents, Path.home()]
        escaped = [path for place in places if (path := place / ESCAPED).exists()]
        left = [*scratch.iterdir(), *escaped]
        for path in left:
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        return f"leaves {', '.join(map(str, left))}" if left else ""

    def _hear(self, event: str, arguments: tuple) -> None:
        if not self._on:
            return
        started = event == "subprocess.Popen" and arguments[0] not in self._programs
        if started or event.startswith(FORBIDDEN):
            self._seen = f"{event} {arguments}"
        elif event == "open" and isinstance(arguments[0], str | bytes):
            path, _, flags = arguments
            writes = isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            inside = os.fsdecode(path).startswith((self._box, os.devnull, "/proc/self"))
            if writes and not inside and os.fsdecode(path).startswith(os.sep):
                self._seen = f"writes {os.fsdecode(path)}"


def _keep(file: Path, keep: Path, target: Format, seed: int, why: str) -> None:
    keep.mkdir(parents=True, exist_ok=True)
    number = len(list(keep.glob(f"{target.name}-*.why")))
    if number >= 50:  # of a format; more are seldom others
        return
    stem = keep / f"{target.name}-{number:03d}"
    stem.with_suffix(".case").write_bytes(file.read_bytes() if file.is_file() else b"")
    stem.with_suffix(".why").write_text(f"seed {seed}\n{why}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
