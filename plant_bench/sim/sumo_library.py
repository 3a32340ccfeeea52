"""Selects SUMO's interface: libsumo in this process, or TraCI with a window of sumo-gui.

With `GUI_VARIABLE` in the environment, every simulation of this process and of its workers runs in
sumo-gui. Both interfaces have the same functions, and the same simulation steps follow.
"""

import os
import sys
from contextlib import redirect_stdout
from pathlib import Path

GUI_VARIABLE = "PLANT_BENCH_SUMO_GUI"  # its value is the delay of a step, milliseconds

GUI_DELAY = os.environ.get(GUI_VARIABLE, "")

if GUI_DELAY:
    import sumo
    import traci as libsumo

    PROGRAM = str(Path(sumo.SUMO_HOME) / "bin" / "sumo-gui")
else:
    with redirect_stdout(sys.stderr):  # it warns if pyarrow is not the version that it bundles
        import libsumo

    PROGRAM = "sumo"

SumoError = libsumo.TraCIException  # raised for a vehicle that SUMO does not know, for instance

__all__ = ["GUI_DELAY", "GUI_VARIABLE", "PROGRAM", "SumoError", "libsumo"]
