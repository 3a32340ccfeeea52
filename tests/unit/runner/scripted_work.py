"""Scripted work for worker processes; workers import this module by name."""

import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.ray.payload import NodePaths, Requirements


@dataclass(frozen=True)
class Step:
    """One task: its action, and a file that exists if it was tried before."""

    act: str
    value: int = 0
    marker: Path | None = None
    requirements: Requirements = field(default_factory=Requirements)
    output: Path | None = None

    def with_paths(self, paths: NodePaths) -> "Step":
        return replace(self, output=paths.output)


def fail(error: Exception) -> Callable[[Step], int]:
    def act(step: Step) -> int:
        raise error

    return act


def give(step: Step) -> int:
    return step.value


def kill(step: Step) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return step.value


def talk(step: Step) -> int:
    sys.stdout.write("seen in the log\n")
    return step.value


def sleep(step: Step) -> int:
    time.sleep(60)
    return step.value


def write(step: Step) -> int:
    assert step.output is not None
    (step.output / "recordings").mkdir(parents=True, exist_ok=True)
    (step.output / "recordings" / f"{step.value}.parquet").write_bytes(b"ticks")
    return step.value


def known(step: Step) -> int:
    assert step.marker is not None
    step.marker.write_text(str("http.cookies" in sys.modules))
    return step.value


ACTS: dict[str, Callable[[Step], int]] = {
    "exit": lambda step: os._exit(7),
    "kill": kill,
    "simulation-error": fail(SimulationError("the ego was lost")),
    "bug": fail(ZeroDivisionError("of a bug")),
    "input-error": fail(InputError("no such town")),
    "disk": fail(OSError(28, "No space left on device")),
    "sleep": sleep,
    "threads": lambda step: int(os.environ["OMP_NUM_THREADS"]),
    "print": talk,
    "known": known,
    "pid": lambda step: os.getpid(),
    "write": write,
}


def do(step: Step, report: Callable[[float], None]) -> int:
    report(0.5)
    tried = step.marker is not None and step.marker.exists()
    if step.marker is not None:
        step.marker.touch()
    if step.act.endswith("once") and tried:
        return step.value
    return ACTS.get(step.act.partition(" ")[0], give)(step)
