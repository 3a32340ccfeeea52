"""Benchmark: time of `plant-bench score` from the command to the first tick.

    python benchmarks/start_up.py --agents cruise expert plant --repeat 5

Each time is that of a whole new `plant-bench` command; the first of its workers that comes so far
writes down when its simulation is asked for its first step, and all is ended then. The first
command of all compiles planners' loops and Python's modules and fills the disk's cache, so it is
not counted.
"""

import argparse
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from clock_of_first_tick import CLOCK

PATIENCE = 120.0  # s


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--agents", nargs="+", default=["cruise", "expert", "plant"])
    parser.add_argument("--routes", default="0", help="as of plant-bench score: one a worker")
    parser.add_argument("--workers", default="1")
    parser.add_argument("--repeat", type=int, default=5)
    given = parser.parse_args()
    for agent in given.agents:
        first_tick(agent, given.routes, given.workers)
        times = [first_tick(agent, given.routes, given.workers) for _ in range(given.repeat)]
        low, middle, high = min(times), statistics.median(times), max(times)
        print(
            f"{agent:20s} {middle:5.2f} s to the first tick ({low:.2f} to {high:.2f})", flush=True
        )


def first_tick(agent: str, routes: str, workers: str) -> float:
    """Return the seconds from the start of a command to its first tick."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        clock, run = Path(folder) / "clock", Path(folder) / "run"
        # Python loads a module of this name first of all, in the command and in its workers.
        shutil.copy(
            Path(__file__).with_name("clock_of_first_tick.py"), f"{folder}/sitecustomize.py"
        )
        command = [sys.executable, "-m", "plant_bench", "score", "--agent", agent]
        command += ["--routes", routes, "--repetitions", "1", "--workers", workers]
        command += ["--out", str(run)]
        paths = filter(None, (folder, os.environ.get("PYTHONPATH")))
        env = os.environ | {CLOCK: str(clock), "PYTHONPATH": os.pathsep.join(paths)}
        env.pop("PYTHONDONTWRITEBYTECODE", None)  # else each command compiles all modules anew
        begin = time.time()
        child = subprocess.Popen(
            command, env=env, stdout=subprocess.DEVNULL, start_new_session=True
        )
        try:
            while not clock.is_file():
                if child.poll() is not None or time.time() - begin > PATIENCE:
                    sys.exit(f"{' '.join(command)} came to no tick.")
                time.sleep(0.002)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)  # its workers, too
            child.wait()
        return float(clock.read_text(encoding="ascii")) - begin


if __name__ == "__main__":
    main()
