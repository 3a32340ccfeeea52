"""Records the time of a simulation's first step; loaded into Python by `start_up.py`."""

import os
import sys
import threading
import time

CLOCK = "PLANT_BENCH_FIRST_TICK"  # environment variable: the file to which the time is written


def watch(clock: str) -> None:
    """Wait until the simulation module is loaded, then record the time of the first step."""
    while not hasattr(module := sys.modules.get("plant_bench.sim.simulation"), "Simulation"):
        time.sleep(0.02)  # the module is loaded about 0.1 s before the first step
    step = module.Simulation.step

    def timed(self: object, control: object) -> object:
        with open(f"{clock}.part", "w", encoding="ascii") as file:  # noqa: PTH123  loads nothing
            file.write(repr(time.time()))
        os.replace(f"{clock}.part", clock)  # noqa: PTH105
        module.Simulation.step = step
        return step(self, control)

    module.Simulation.step = timed


if clock_file := os.environ.get(CLOCK):
    threading.Thread(target=watch, args=(clock_file,), daemon=True).start()
