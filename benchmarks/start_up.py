"""Benchmark: time of `plant-bench score` from the command to the first tick.

    python benchmarks/start_up.py --agents cruise expert plant --repeat 5

Each measurement starts a new `plant-bench` command. The first worker to reach the first step of its
simulation records the time, and the command is then killed. The first command of each planner is
not counted, since it compiles loops and modules and fills the disk cache.
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

TIMEOUT = 120.0  # s


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--agents", nargs="+", default=["cruise", "expert", "plant"])
    parser.add_argument("--routes", default="0", help="as in plant-bench score; one per worker")
    parser.add_argument("--workers", default="1")
    parser.add_argument("--repeat", type=int, default=5)
    arguments = parser.parse_args()
    for agent in arguments.agents:
        first_tick(agent, arguments.routes, arguments.workers)
        times = [
            first_tick(agent, arguments.routes, arguments.workers) for _ in range(arguments.repeat)
        ]
        low, middle, high = min(times), statistics.median(times), max(times)
        print(
            f"{agent:20s} {middle:5.2f} s to the first tick ({low:.2f} to {high:.2f})", flush=True
        )


def first_tick(agent: str, routes: str, workers: str) -> float:
    """Return the seconds from the start of a command to its first tick."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        clock, run = Path(folder) / "clock", Path(folder) / "run"
        # Python imports a module of this name at start-up, in the command and in its workers.
        shutil.copy(
            Path(__file__).with_name("clock_of_first_tick.py"), f"{folder}/sitecustomize.py"
        )
        command = [sys.executable, "-m", "plant_bench", "score", "--agent", agent]
        command += ["--routes", routes, "--repetitions", "1", "--workers", workers]
        command += ["--out", str(run)]
        paths = filter(None, (folder, os.environ.get("PYTHONPATH")))
        env = os.environ | {CLOCK: str(clock), "PYTHONPATH": os.pathsep.join(paths)}
        env.pop("PYTHONDONTWRITEBYTECODE", None)  # otherwise each command compiles all modules
        begin = time.time()
        child = subprocess.Popen(
            command, env=env, stdout=subprocess.DEVNULL, start_new_session=True
        )
        try:
            while not clock.is_file():
                if child.poll() is not None or time.time() - begin > TIMEOUT:
                    sys.exit(f"{' '.join(command)} did not reach the first tick.")
                time.sleep(0.002)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)  # including its workers
            child.wait()
        return float(clock.read_text(encoding="ascii")) - begin


if __name__ == "__main__":
    main()
