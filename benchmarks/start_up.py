"""How long `plant-bench score` takes from the command to the first tick of its first episode.

    python benchmarks/start_up.py --agents cruise expert plant --repeat 5

Each time is that of a whole new command with one worker; its worker writes down when the simulation
is asked for its first step, and all is ended then. The first command of all compiles planners'
loops and fills the disk's cache, so it is not counted.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

CLOCK = "PLANT_BENCH_FIRST_TICK"  # names the file that takes the time, in the child's processes
PATIENCE = 120.0  # s


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--agents", nargs="+", default=["cruise", "expert", "plant"])
    parser.add_argument("--route", default="0")
    parser.add_argument("--repeat", type=int, default=5)
    given = parser.parse_args()
    for agent in given.agents:
        first_tick(agent, given.route)
        times = [first_tick(agent, given.route) for _ in range(given.repeat)]
        low, middle, high = min(times), statistics.median(times), max(times)
        print(
            f"{agent:20s} {middle:5.2f} s to the first tick ({low:.2f} to {high:.2f})", flush=True
        )


def first_tick(agent: str, route: str) -> float:
    """Return the seconds from the start of a command to its first tick."""
    with tempfile.TemporaryDirectory() as folder:
        clock = Path(folder) / "clock"
        command = [sys.executable, __file__, "score", "--agent", agent, "--routes", route]
        command += ["--repetitions", "1", "--workers", "1", "--out", str(Path(folder) / "run")]
        begin = time.time()
        child = subprocess.Popen(
            command, env=os.environ | {CLOCK: str(clock)}, stdout=subprocess.DEVNULL
        )
        try:
            while not clock.is_file():
                if child.poll() is not None or time.time() - begin > PATIENCE:
                    sys.exit(f"{' '.join(command[2:])} came to no tick.")
                time.sleep(0.002)
        finally:
            child.kill()
            child.wait()
        return float(clock.read_text(encoding="ascii")) - begin


def watch(clock: Path) -> None:
    """Wait for the simulation's module to be loaded, and for its first step."""
    while (module := sys.modules.get("plant_bench.sim.simulation")) is None or not hasattr(
        module, "Simulation"
    ):
        time.sleep(0.001)
    step = module.Simulation.step

    def timed(self: object, control: object) -> object:
        part = clock.with_suffix(".part")
        part.write_text(repr(time.time()), encoding="ascii")
        part.replace(clock)
        module.Simulation.step = step
        return step(self, control)

    module.Simulation.step = timed


if clock_file := os.environ.get(CLOCK):
    threading.Thread(target=watch, args=(Path(clock_file),), daemon=True).start()
if __name__ == "__main__":
    if CLOCK in os.environ:
        from plant_bench.cli import main as command_line

        command_line()
    else:
        main()
