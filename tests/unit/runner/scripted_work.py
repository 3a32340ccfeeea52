"""Work for worker processes, as the tests want it; imported by the workers by this name."""

import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from plant_bench.errors import InputError, SimulationError


@dataclass(frozen=True)
class Step:
    """One task: what to do, and a file that tells whether it was tried before."""

    act: str
    value: int = 0
    marker: Path | None = None


def do(step: Step, report: Callable[[float], None]) -> int:
    report(0.5)
    tried = step.marker is not None and step.marker.exists()
    if step.marker is not None:
        step.marker.touch()
    if step.act.endswith("once") and tried:
        return step.value
    match step.act.partition(" ")[0]:
        case "exit":
            os._exit(7)
        case "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        case "simulation-error":
            raise SimulationError("the ego was lost")
        case "bug":
            raise ZeroDivisionError("of a bug")
        case "input-error":
            raise InputError("no such town")
        case "disk":
            raise OSError(28, "No space left on device")
        case "sleep":
            time.sleep(60)
        case "threads":
            return int(os.environ["OMP_NUM_THREADS"])
        case "print":
            print("seen in the log")
    return step.value
