"""Fault injection: interrupts runs at random times, resumes them, compares with a reference run.

    python benchmarks/kills.py --kills 200

A small suite with SUMO is driven repeatedly, with one fault per command: a process or all of them
are killed at a random time or at a certain point of writing a file (after some bytes; before or
after content, renaming and folder are synced); or there is a power cut at that point (unsynced data
are lost), or a full disk. The same command then resumes the run. Whenever the suite is finished,
records, recordings and summary must equal those of the reference run byte for byte, without any
additional files. The exit code is 1 if not.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from plant_bench.towns.routes import suite_text
from plant_bench.world.route import load_suite

HERE = Path(__file__).resolve().parent
FIRST_METRES = 50  # of each route
INSTANTS = ("written", "synced", "renaming", "renamed", "folder", "folder synced")
DERIVED = ("run.json", "timing", "speed.json", "logs")  # depend on time or command; not compared
DONE, BAD_INPUT = 0, 2


@dataclass
class Results:
    """Counts of faults and failures; mutable."""

    faults: Counter[str] = field(default_factory=Counter)
    finished: int = 0
    lost: int = 0
    duplicated: int = 0
    differing: int = 0
    problems: list[str] = field(default_factory=list)

    @property
    def clean(self) -> bool:
        """Whether there was no failure."""
        return not (self.lost or self.duplicated or self.differing or self.problems)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kills", type=int, default=200, help="number of faults to inject")
    parser.add_argument("--routes", type=int, default=6, help="number of routes, each driven once")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--agent", default="cruise")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kills-") as work:
        results = inject_faults(Path(work), arguments)
    for kind, count in sorted(results.faults.items()):
        print(f"{count:5d}  {kind}")
    print(
        f"{sum(results.faults.values())} faults over {results.finished} suites: "
        f"{results.lost} lost, {results.duplicated} duplicated, {results.differing} differing "
        f"records; {len(results.problems)} other faults"
    )
    for line in results.problems:
        print(f"  {line}")
    sys.exit(0 if results.clean else 1)


def inject_faults(work: Path, arguments: argparse.Namespace) -> Results:
    """Drive the suite with faults until enough of them have taken effect."""
    rng, results = random.Random(arguments.seed), Results()
    suite = work / "suite.json"
    suite.write_text(
        suite_text({"suite": "kills"}, _short_routes(arguments.routes)), encoding="utf-8"
    )
    command = [sys.executable, "-m", "plant_bench", "score", "--agent", arguments.agent]
    command += ["--suite", str(suite), "--repetitions", "1", "--workers", str(arguments.workers)]
    started = time.monotonic()
    _command([*command, "--out", "reference"], work, {}).wait()
    reference, duration = _content(work / "reference"), time.monotonic() - started
    while sum(results.faults.values()) < arguments.kills:
        shutil.rmtree(work / "run", ignore_errors=True)
        code = -1
        while code != DONE:
            spare = sum(results.faults.values()) < arguments.kills
            code = _run_with_fault(command, work, rng, duration, results if spare else None)
        _compare(reference, _content(work / "run"), results)
        print(f"{sum(results.faults.values())} faults, {results.finished} suites", file=sys.stderr)
    return results


def _short_routes(count: int) -> list:
    """Return shortened routes in different towns."""
    found = []
    for route in load_suite("longest6")[:: max(36 // count, 1)][:count]:
        keep = FIRST_METRES
        short = replace(
            route,
            points=route.points[: keep + 1],
            elevations=route.elevations[: keep + 1],
            speed_limits=route.speed_limits[: keep + 1],
            passages=tuple(item for item in route.passages if item.exit < keep),
            hazards=tuple(item for item in route.hazards if item.at < keep),
        )
        found.append(short)
    return found


def _command(command: Sequence[str], work: Path, fault: dict[str, str]) -> subprocess.Popen:
    path = os.pathsep.join([str(HERE / "faults"), os.environ.get("PYTHONPATH", str(HERE.parent))])
    return subprocess.Popen(
        command,
        cwd=work,
        env=os.environ | {"PYTHONPATH": path, "NO_COLOR": "1"} | fault,
        stdout=subprocess.DEVNULL,
        stderr=(work / "output").open("w"),
        start_new_session=True,
    )


def _run_with_fault(
    command: Sequence[str], work: Path, rng: random.Random, duration: float, results: Results | None
) -> int:
    """Run the command, with a fault unless `results` is None; return its exit code."""
    kind, variables, delay = ("none", {}, None) if results is None else _draw(rng, duration)
    once = work / "once"
    once.unlink(missing_ok=True)
    process = _command([*command, "--out", "run"], work, variables | {"FAULT_ONCE": str(once)})
    struck = False
    if delay is not None:
        struck = _kill_later(process, kind, delay, rng)
    code = process.wait()
    if results is not None and (struck or once.exists()):
        results.faults[kind] += 1
        full = kind.endswith("full")
        output = (work / "output").read_text(encoding="utf-8", errors="replace")
        if "Traceback" in output or (full and code not in (DONE, BAD_INPUT)):
            results.problems.append(f"{kind}: exit code {code}: {output[-300:]!r}")
    _end_group(process.pid)
    return code


def _draw(rng: random.Random, duration: float) -> tuple[str, dict[str, str], float | None]:
    """Draw a fault; return its kind, its environment variables and the delay of a kill, seconds."""
    family = rng.choice(("time", "time", "instant", "instant", "bytes"))
    if family == "time":
        who = rng.choice(("parent", "worker", "all"))
        return f"kill of {who} at a random time", {}, rng.uniform(0.0, duration)
    process = rng.choice(("parent", "worker"))
    if family == "bytes":
        action, size = rng.choice(("kill", "full")), int(10 ** rng.uniform(0, 4.7))
        if process == "parent":
            size = min(size, 2000)
        fault = f"{process}:bytes:{size}:{action}"
        return f"{process}, after some bytes: {action}", {"FAULT": fault}, None
    instant = rng.choice(INSTANTS)
    action = rng.choice(("kill", "cut", "full"))
    if process == "worker" and rng.random() < 0.25:
        action = "kill-parent"
    number = rng.randint(1, 3 if process == "worker" else 12)
    fault = f"{process}:{instant}:{number}:{action}"
    return f"{process}, {instant}: {action}", {"FAULT": fault}, None


def _kill_later(process: subprocess.Popen, kind: str, delay: float, rng: random.Random) -> bool:
    """Kill processes after a delay; return whether there was any to kill."""
    try:
        process.wait(delay)
    except subprocess.TimeoutExpired:
        pass
    else:
        return False
    if " worker " in kind:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        workers = [pid for pid in children if "--multiprocessing-fork" in _command_line_of(pid)]
        if not workers:
            return False
        os.kill(int(rng.choice(workers)), signal.SIGKILL)
    elif " all " in kind:
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    return True


def _command_line_of(pid: str) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _end_group(group: int) -> None:
    """Kill the remaining workers of a killed parent, which would end by themselves a bit later."""
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return


def _content(run: Path) -> dict[str, bytes]:
    files = (path for path in run.rglob("*") if path.is_file())
    named = {path.relative_to(run).as_posix(): path for path in files}
    return {
        name: path.read_bytes() for name, path in named.items() if name.split("/")[0] not in DERIVED
    }


def _compare(reference: dict[str, bytes], now: dict[str, bytes], results: Results) -> None:
    results.finished += 1
    results.lost += len(reference.keys() - now.keys())
    extra = sorted(now.keys() - reference.keys())
    results.duplicated += sum(name.startswith("episodes/") for name in extra)
    results.problems += [f"left over: {name}" for name in extra if not name.startswith("episodes/")]
    differing = [name for name in reference.keys() & now.keys() if reference[name] != now[name]]
    results.differing += len(differing)
    results.problems += [f"differs: {name}" for name in differing]


if __name__ == "__main__":
    main()
