"""Prepares this process and its workers to run SUMO in a window."""

import os
import sys

from plant_bench.errors import InputError
from plant_bench.runner.workers.window import VARIABLE

REAL_TIME = 50.0  # ms per step of 0.05 s


def use_gui(speed: float) -> None:
    """Run all further simulations of this process and its workers in sumo-gui.

    Call before `plant_bench.sim.sumo_library` is imported.

    Args:
        speed: Multiple of real time at which episodes are shown, at most.

    Raises:
        InputError: There is no display.
    """
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        message = (
            "--gui needs a display, and DISPLAY is not set. On a server without a screen, run the "
            "command below `xvfb-run -a`."
        )
        raise InputError(message)
    os.environ[VARIABLE] = f"{REAL_TIME / speed:g}"
