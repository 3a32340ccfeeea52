"""How the speed and heading of others have changed in the last half second: what a tracker tells.

A planner that sees one instant only cannot tell who pulls away from who crawls, nor who turns from
who goes straight on. Nothing here is privileged: it is the difference of two observations.
"""

import copy
import math
from collections import deque
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from plant_bench.jit import REAL, SINGLES, SINGLES_2D, WHOLES, compiled
from plant_bench.world.scene import Actors

# s between the two observations: half a second, as in the data, less what decisions are apart.
LEAST_SPAN = 0.44
MOTION_ATTRIBUTES = 2


class Rates(NamedTuple):
    """How actors change; 0 for who was not in sight before.

    Attributes:
        accelerations: m/s2.
        turns: rad/s, counter-clockwise.
    """

    accelerations: Float[np.ndarray, " actors"]
    turns: Float[np.ndarray, " actors"]


def no_rates(actors: Actors) -> Rates:
    """Return rates of nothing but 0."""
    return Rates(np.zeros(len(actors), np.float32), np.zeros(len(actors), np.float32))


def rows_of(
    ids: Int[np.ndarray, " wanted"], among: Int[np.ndarray, " actors"]
) -> tuple[Int[np.ndarray, " found"], Int[np.ndarray, " found"]]:
    """Return which of some ids are among others, and their rows there."""
    if not len(among):
        nobody = np.empty(0, np.intp)
        return nobody, nobody
    order = among.argsort()
    rows = order[np.searchsorted(among, ids, sorter=order).clip(max=len(order) - 1)]
    found = np.flatnonzero(among[rows] == ids)
    return found, rows[found]


def rates_between(before: Actors, now: Actors, seconds: float) -> Rates:
    """Return how actors have changed between two instants, in the order of the later one."""
    return Rates(
        *_rates_between(
            before.ids, before.poses, before.speeds, now.ids, now.poses, now.speeds, seconds
        )
    )


@compiled(WHOLES, SINGLES_2D, SINGLES, WHOLES, SINGLES_2D, SINGLES, REAL)
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
    """Remembers who was where in the last half second; mutable."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Actors]] = deque()
        self._latest: tuple[Actors, Rates] | None = None

    def forget(self) -> None:
        """Start anew."""
        self._seen.clear()
        self._latest = None

    def copied(self) -> "MotionTracker":
        """Return tracks that remember the same, and go on apart from these."""
        other = copy.copy(self)
        other._seen = self._seen.copy()
        return other

    def rates(self, time: float, actors: Actors) -> Rates:
        """Return how actors seen now have changed, and remember them; asked again, the same.

        Args:
            time: Of the observation, seconds.
            actors: In it.
        """
        if self._latest is not None and self._latest[0] is actors:
            return self._latest[1]
        rates = self._changes(time, actors)
        self._latest = actors, rates
        return rates

    def _changes(self, time: float, actors: Actors) -> Rates:
        seen = self._seen
        if not seen or time > seen[-1][0]:
            seen.append((time, actors))
        while len(seen) > 1 and time - seen[1][0] >= LEAST_SPAN:
            seen.popleft()
        then, before = seen[0]
        if time - then < LEAST_SPAN:
            return no_rates(actors)
        return rates_between(before, actors, time - then)
