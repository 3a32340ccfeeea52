"""Fault test: kills runs at random times, resumes them, compares with an uninterrupted run.

    python benchmarks/kills.py --kills 200

A small suite with SUMO is driven again and again. Each command meets one fault: a process, or all
of them, are killed at a random time or at an instant of writing a file (after so many bytes, before
and after the content, the renaming and the folder are on the disk), the power is cut there (what
was not on the disk is lost), or the disk is full there. The same command then goes on. Whenever the
suite is finished, records, recordings and summary must be those of the undisturbed run, byte for
byte, and nothing else may lie there. Exit code 1 if not.
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
DERIVED = ("run.json", "timing", "speed.json", "logs")  # of the clock, or of the command
DONE, BAD_INPUT = 0, 2


@dataclass
class Toll:
    """What was counted; mutable."""

    faults: Counter[str] = field(default_factory=Counter)
    finished: int = 0
    lost: int = 0
    doubled: int = 0
    differing: int = 0
    untidy: list[str] = field(default_factory=list)

    @property
    def clean(self) -> bool:
        """Whether nothing went wrong."""
        return not (self.lost or self.doubled or self.differing or self.untidy)


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kills", type=int, default=200, help="faults that struck")
    parser.add_argument("--routes", type=int, default=6, help="of the suite, each once")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--agent", default="cruise")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kills-") as work:
        toll = torment(Path(work), given)
    for kind, count in sorted(toll.faults.items()):
        print(f"{count:5d}  {kind}")
    print(
        f"{sum(toll.faults.values())} faults over {toll.finished} suites: {toll.lost} lost, "
        f"{toll.doubled} duplicated, {toll.differing} differing records; "
        f"{len(toll.untidy)} other faults"
    )
    for line in toll.untidy:
        print(f"  {line}")
    sys.exit(0 if toll.clean else 1)


def torment(work: Path, given: argparse.Namespace) -> Toll:
    """Disturb runs until so many faults have struck."""
    chance, toll = random.Random(given.seed), Toll()
    suite = work / "suite.json"
    suite.write_text(suite_text({"suite": "kills"}, _short_routes(given.routes)), encoding="utf-8")
    command = [sys.executable, "-m", "plant_bench", "score", "--agent", given.agent]
    command += ["--suite", str(suite), "--repetitions", "1", "--workers", str(given.workers)]
    started = time.monotonic()
    _command([*command, "--out", "calm"], work, {}).wait()
    calm, duration = _content(work / "calm"), time.monotonic() - started
    while sum(toll.faults.values()) < given.kills:
        shutil.rmtree(work / "run", ignore_errors=True)
        code = -1
        while code != DONE:
            spare = sum(toll.faults.values()) < given.kills
            code = _disturbed(command, work, chance, duration, toll if spare else None)
        _compare(calm, _content(work / "run"), toll)
        print(f"{sum(toll.faults.values())} faults, {toll.finished} suites", file=sys.stderr)
    return toll


def _short_routes(count: int) -> list:
    """Return the first metres of routes in different towns."""
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
        stderr=(work / "said").open("w"),
        start_new_session=True,
    )


def _disturbed(
    command: Sequence[str], work: Path, chance: random.Random, duration: float, toll: Toll | None
) -> int:
    """Run the command with a fault, if there is a toll to take; return its exit code."""
    kind, variables, delay = ("none", {}, None) if toll is None else _draw(chance, duration)
    once = work / "once"
    once.unlink(missing_ok=True)
    process = _command([*command, "--out", "run"], work, variables | {"FAULT_ONCE": str(once)})
    struck = False
    if delay is not None:
        struck = _kill_later(process, kind, delay, chance)
    code = process.wait()
    if toll is not None and (struck or once.exists()):
        toll.faults[kind] += 1
        full = kind.endswith("full")
        said = (work / "said").read_text(encoding="utf-8", errors="replace")
        if "Traceback" in said or (full and code not in (DONE, BAD_INPUT)):
            toll.untidy.append(f"{kind}: exit code {code}: {said[-300:]!r}")
    _end_group(process.pid)
    return code


def _draw(chance: random.Random, duration: float) -> tuple[str, dict[str, str], float | None]:
    """Return the kind of a fault, the variables that bring it, and after how long it comes."""
    family = chance.choice(("time", "time", "instant", "instant", "bytes"))
    if family == "time":
        who = chance.choice(("parent", "worker", "all"))
        return f"kill of {who} at a random time", {}, chance.uniform(0.0, duration)
    process = chance.choice(("parent", "worker"))
    if family == "bytes":
        action, size = chance.choice(("kill", "full")), int(10 ** chance.uniform(0, 4.7))
        if process == "parent":
            size = min(size, 2000)
        fault = f"{process}:bytes:{size}:{action}"
        return f"{process}, after some bytes: {action}", {"FAULT": fault}, None
    instant = chance.choice(INSTANTS)
    action = chance.choice(("kill", "cut", "full"))
    if process == "worker" and chance.random() < 0.25:
        action = "kill-parent"
    number = chance.randint(1, 3 if process == "worker" else 12)
    fault = f"{process}:{instant}:{number}:{action}"
    return f"{process}, {instant}: {action}", {"FAULT": fault}, None


def _kill_later(process: subprocess.Popen, kind: str, delay: float, chance: random.Random) -> bool:
    """Kill after a while; return whether there was something to kill."""
    try:
        process.wait(delay)
    except subprocess.TimeoutExpired:
        pass
    else:
        return False
    if " worker " in kind:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        workers = [pid for pid in children if "--multiprocessing-fork" in _said_of(pid)]
        if not workers:
            return False
        os.kill(int(chance.choice(workers)), signal.SIGKILL)
    elif " all " in kind:
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    return True


def _said_of(pid: str) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _end_group(group: int) -> None:
    """End what a killed parent has left; its workers would end by themselves a little later."""
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


def _compare(calm: dict[str, bytes], now: dict[str, bytes], toll: Toll) -> None:
    toll.finished += 1
    toll.lost += len(calm.keys() - now.keys())
    extra = sorted(now.keys() - calm.keys())
    toll.doubled += sum(name.startswith("episodes/") for name in extra)
    toll.untidy += [f"left over: {name}" for name in extra if not name.startswith("episodes/")]
    differing = [name for name in calm.keys() & now.keys() if calm[name] != now[name]]
    toll.differing += len(differing)
    toll.untidy += [f"differs: {name}" for name in differing]


if __name__ == "__main__":
    main()
