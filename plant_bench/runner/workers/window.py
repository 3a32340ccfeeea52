"""Recognises that the user has closed the window of sumo-gui."""

import os

VARIABLE = "PLANT_BENCH_SUMO_GUI"  # as `plant_bench.sim.sumo_library.GUI_VARIABLE`
WINDOW_CLOSED = "The window was closed."


def is_window_closed(error: Exception) -> bool:
    """Return whether an exception means that the connection to sumo-gui has ended.

    The class is recognised by its name, because `traci` is imported only with a window.
    """
    lost = type(error).__name__ == "FatalTraCIError" or isinstance(error, ConnectionError)
    return lost and bool(os.environ.get(VARIABLE))
