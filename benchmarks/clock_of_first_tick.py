"""Records the time of a simulation's first step; loaded into Python by `start_up.py`."""

import os
import sys
import threading
import time

CLOCK = "PLANT_BENCH_FIRST_TICK"  # names the file that takes the time


def watch(clock: str) -> None:
    """Wait for the simulation's module to be loaded, and for its first step."""
    while not hasattr(module := sys.modules.get("plant_bench.sim.simulation"), "Simulation"):
        time.sleep(0.02)  # the module is there a tenth of a second before the step
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
