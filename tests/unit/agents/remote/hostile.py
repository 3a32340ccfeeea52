"""Planners that misbehave, each in one way; only run isolated."""

import contextlib
import ctypes
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from plant_bench.agent import Cause, Control, Input, Plan, Reason
from plant_bench.inference_timing import forward_pass

BRAKE = Control(-1.0, 0.0)


def note_process():
    """Write the process id for the test."""
    with Path(os.environ["HOSTILE_PIDS"]).open("a") as file:
        file.write(f"{os.getpid()}\n")


class Good:
    """Drives, and does something else at its third decision."""

    inputs = frozenset({Input.ROUTE})
    decisions = 0

    def reset(self, route):
        self.decisions = 0

    def act(self, observation):
        self.decisions += 1
        return Control(1.0, 0.0) if self.decisions < 3 else self.third()

    def third(self) -> Any:
        return Control(0.5, 0.0)


class Hangs(Good):
    def third(self):
        while True:
            time.sleep(1.0)


class Leaks(Good):
    def third(self):
        kept = []
        while True:
            kept.append(np.ones(1_000_000))


class LeaksInAChild(Good):
    def third(self):
        if os.fork() == 0:
            Leaks().third()
        time.sleep(600.0)


class WantsAll(Good):
    def third(self):
        return np.ones(10_000_000_000)


class Segfaults(Good):
    def third(self):
        ctypes.string_at(0)


class Raises(Good):
    def third(self):
        raise ValueError(f"no way out of {object()}")


class AnswersNaN(Good):
    def third(self):
        return Control(float("nan"), 0.0)


class AnswersNothing(Good):
    def third(self):
        return None


class ExitsAtOnce(Good):
    def third(self):
        os._exit(3)


class Exits(Good):
    def third(self):
        sys.exit(4)


class PrintsForEver(Good):
    def third(self):
        while True:
            sys.stdout.write("x" * 10_000)


class PrintsInAThread(Good):
    """Goes on driving."""

    def third(self):
        if self.decisions == 3:
            threading.Thread(target=PrintsForEver().third, daemon=True).start()
        return BRAKE


class ClosesItsPipe(Good):
    def third(self):
        os.closerange(3, 100)
        time.sleep(600.0)


class AnswersGarbage(Good):
    def third(self):
        for descriptor in range(3, 30):
            with contextlib.suppress(OSError):
                os.write(descriptor, b"\x05\x00\x00\x00hello world")
        time.sleep(600.0)


class AnnouncesTooMuch(Good):
    def third(self):
        for descriptor in range(3, 30):
            with contextlib.suppress(OSError):
                os.write(descriptor, b"\xff" * 8)
        time.sleep(600.0)


def start_daemon():
    """Start a process that leaves its group and its parent."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            note_process()
            time.sleep(600.0)
        os._exit(0)
    time.sleep(0.1)


class LeavesADaemon(Good):
    def third(self):
        start_daemon()
        os._exit(0)


class HangsWithADaemon(Good):
    def third(self):
        note_process()
        start_daemon()
        time.sleep(600.0)


class DiesAtReset(Good):
    def reset(self, route):
        os._exit(5)


class Explains(Good):
    """Returns reasons, ranks, forward passes and intervals."""

    interval = 3

    def third(self):
        self.interval = 7
        with forward_pass(tokens=5):
            return Plan(np.ones((4, 2)))

    def explain(self):
        return Reason(Cause.LEADER, 11)

    def rank(self, observation):
        return np.arange(len(observation.actors or ()), dtype=float)


class ByRoute(Good):
    """Behaves on each route as the route's name says."""

    kind = Good

    def reset(self, route):
        self.decisions = 0
        self.kind = globals()[route.id.partition("-")[0]]

    def third(self):
        return self.kind.third(self)
