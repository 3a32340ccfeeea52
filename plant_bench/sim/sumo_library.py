"""Imports libsumo with its import-time output redirected to stderr."""

import sys
from contextlib import redirect_stdout

with redirect_stdout(sys.stderr):  # it warns if pyarrow is not the version that it bundles
    import libsumo

__all__ = ["libsumo"]
