"""SUMO's library, imported so that what it prints then does not get into a command's results."""

import sys
from contextlib import redirect_stdout

with redirect_stdout(sys.stderr):  # a warning, where pyarrow is not the version it bundles
    import libsumo

__all__ = ["libsumo"]
