"""Random walks of pedestrians: poses every half metre, and where they cross roads."""

import random
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.roadside.footways import Crossing, Footways, Heading

SAMPLE = 0.5  # m between the poses of a walk
WALK = 600.0  # m per walker: seven minutes
SAMPLES = int((WALK + 130.0) / SAMPLE)  # plus 130 m of path ahead at the end
HALF_BODY = 0.3  # m
TO_THE_RIGHT = (0.1, 0.4)  # m that pedestrians keep to the right of the centre line
TURN_LENGTH = 0.5  # m over which heading is measured, before and after a place


class Kerb(NamedTuple):
    """A place where a walk crosses a road; arc lengths on the walk.

    Attributes:
        wait: Where the walker waits.
        enter: Where the body reaches the road.
        leave: Where the body has left the road.
        crossing: The crossing.
    """

    wait: float
    enter: float
    leave: float
    crossing: Crossing


class Walk(NamedTuple):
    """A pedestrian's path.

    Attributes:
        samples: x, y, yaw and z every `SAMPLE` metres.
        kerbs: Where it crosses roads, in order.
    """

    samples: Float[np.ndarray, "samples 4"]
    kerbs: tuple[Kerb, ...]


def random_walk(ways: Footways, start: Heading, at: float, draw: random.Random) -> Walk:
    """Return a random walk that starts at an arc length of a sidewalk."""
    first = ways.line(start)
    along = arc_lengths(first[:, :2])
    begin = [np.interp(at, along, first[:, axis]) for axis in range(3)]
    parts = [np.array([begin]), first[along > at + 0.1]]
    count = 1 + len(parts[1])
    marks: list[tuple[int, float, Crossing]] = []  # the crossing's first vertex, and the setback
    for turn in ways.walk(start, draw, WALK + 150.0):
        if turn.crossing is not None:
            marks.append((count, turn.setback, turn.crossing))
            ends = turn.crossing.points[::-1] if turn.reverse else turn.crossing.points
            parts.append(np.array(ends))
            count += 2
        parts.append(ways.line(turn.onto))
        count += len(parts[-1])
    line = _moved_right(np.concatenate(parts), draw.uniform(*TO_THE_RIGHT))
    reached = arc_lengths(line[:, :2])
    kerbs = tuple(
        Kerb(
            float(reached[vertex]) - setback,
            float(reached[vertex]) - HALF_BODY,
            float(reached[vertex + 1]) + HALF_BODY,
            crossing,
        )
        for vertex, setback, crossing in marks
    )
    return Walk(_samples(line, reached), kerbs)


def _moved_right(
    line: Float[np.ndarray, "points 3"], aside: float
) -> Float[np.ndarray, "points 3"]:
    steps = np.hypot(*np.diff(line[:, :2], axis=0).T)
    index = np.arange(len(line))[np.concatenate(([True], steps > 1e-3))]
    kept = line[index]
    ahead = np.diff(kept[:, :2], axis=0)
    ahead /= np.hypot(*ahead.T)[:, None]
    mean = np.concatenate((ahead[:1], ahead[1:] + ahead[:-1], ahead[-1:]))
    mean /= np.maximum(np.hypot(*mean.T), 0.3)[:, None]
    moved = line.copy()
    # Points that repeat move with the last one that is kept, so that indices stay.
    place = np.searchsorted(index, np.arange(len(line)), side="right") - 1
    moved[:, 0] = kept[place, 0] + aside * mean[place, 1]
    moved[:, 1] = kept[place, 1] - aside * mean[place, 0]
    return moved


def _samples(
    line: Float[np.ndarray, "points 3"], along: Float[np.ndarray, " points"]
) -> Float[np.ndarray, "samples 4"]:
    at = SAMPLE * np.arange(SAMPLES)
    x, y, z = (np.interp(at, along, line[:, axis]) for axis in range(3))
    (ax, ay), (bx, by) = (
        [np.interp(at + shift, along, line[:, axis]) for axis in (0, 1)]
        for shift in (TURN_LENGTH, -TURN_LENGTH)
    )
    return np.stack((x, y, np.arctan2(ay - by, ax - bx), z), axis=1)
