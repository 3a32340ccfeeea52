"""How often Python looks for cycles that nothing refers to any more."""

import gc


def tune_garbage_collector() -> None:
    """Let it look seldom in this process: for those that drive or wait for who drives.

    Modules and episodes make hardly any cycles: looking as often as Python does by itself takes a
    quarter of a command's start, and 8 % of an episode. Who makes cycles of large arrays would hold
    them for long.
    """
    gc.set_threshold(100_000, 50, 100)
