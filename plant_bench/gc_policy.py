"""Tunes the cyclic garbage collector of processes that drive episodes."""

import gc


def tune_garbage_collector() -> None:
    """Make the collector run rarely in this process.

    Modules and episodes create hardly any reference cycles; Python's defaults take a quarter of a
    command's start-up and 8 % of an episode. Reference cycles with large arrays would be kept long.
    """
    gc.set_threshold(100_000, 50, 100)
