"""Accelerations and turn rates of actors, from observations half a second apart.

A single observation does not show whether a vehicle is accelerating or turning. Nothing here is
privileged: it is the difference of two observations, as a tracker would provide.
"""

import copy
import math
from collections import deque
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from plant_bench.jit import F32_1D, F32_2D, F64, INT64_1D, compiled
from plant_bench.world.scene import Actors

# s between the two observations, at least: half a second, as in the data, less a decision interval.
MIN_SPAN = 0.44
MOTION_ATTRIBUTES = 2


class Rates(NamedTuple):
    """Accelerations and turn rates of actors; 0 for actors that were not in sight before.

    Attributes:
        accelerations: m/s2.
        turns: Turn rates, rad/s, counter-clockwise.
    """

    accelerations: Float[np.ndarray, " actors"]
    turns: Float[np.ndarray, " actors"]


def no_rates(actors: Actors) -> Rates:
    """Return zero rates for all actors."""
    return Rates(np.zeros(len(actors), np.float32), np.zeros(len(actors), np.float32))


def rows_of(
    ids: Int[np.ndarray, " queries"], among: Int[np.ndarray, " actors"]
) -> tuple[Int[np.ndarray, " found"], Int[np.ndarray, " found"]]:
    """Return the indices of the ids that occur in `among`, and their rows there."""
    if not len(among):
        none = np.empty(0, np.intp)
        return none, none
    order = among.argsort()
    rows = order[np.searchsorted(among, ids, sorter=order).clip(max=len(order) - 1)]
    found = np.flatnonzero(among[rows] == ids)
    return found, rows[found]


def rates_between(before: Actors, now: Actors, seconds: float) -> Rates:
    """Return the rates between two instants, in the order of the later actors."""
    return Rates(
        *_rates_between(
            before.ids, before.poses, before.speeds, now.ids, now.poses, now.speeds, seconds
        )
    )


@compiled(INT64_1D, F32_2D, F32_1D, INT64_1D, F32_2D, F32_1D, F64)
def _rates_between(old_ids, old_poses, old_speeds, ids, poses, speeds, seconds):
    accelerations = np.zeros(len(ids), np.float32)
    turns = np.zeros(len(ids), np.float32)
    for row in range(len(ids)):
        for old in range(len(old_ids)):
            if old_ids[old] != ids[row]:
                continue
            accelerations[row] = (speeds[row] - old_speeds[old]) / np.float32(seconds)
            turned = np.float64(poses[row, 2]) - np.float64(old_poses[old, 2])
            turns[row] = ((turned + math.pi) % (2.0 * math.pi) - math.pi) / seconds
            break
    return accelerations, turns


class MotionTracker:
    """Keeps the observed actors of the last half second and computes their rates; mutable."""

    def __init__(self) -> None:
        self._history: deque[tuple[float, Actors]] = deque()
        self._latest: tuple[Actors, Rates] | None = None

    def reset(self) -> None:
        """Clear the history."""
        self._history.clear()
        self._latest = None

    def copied(self) -> "MotionTracker":
        """Return an independent tracker with the same history."""
        other = copy.copy(self)
        other._history = self._history.copy()
        return other

    def rates(self, time: float, actors: Actors) -> Rates:
        """Return the rates of the observed actors, and add them to the history.

        A second call with the same actors returns the same rates.

        Args:
            time: Time of the observation, seconds.
            actors: The observed actors.
        """
        if self._latest is not None and self._latest[0] is actors:
            return self._latest[1]
        rates = self._changes(time, actors)
        self._latest = actors, rates
        return rates

    def _changes(self, time: float, actors: Actors) -> Rates:
        history = self._history
        if not history or time > history[-1][0]:
            history.append((time, actors))
        while len(history) > 1 and time - history[1][0] >= MIN_SPAN:
            history.popleft()
        then, before = history[0]
        if time - then < MIN_SPAN:
            return no_rates(actors)
        return rates_between(before, actors, time - then)
