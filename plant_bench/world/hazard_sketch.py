"""Sketches of hazards as data: a road from above, the ego's path, and other road users.

Metres; the ego drives to +x, y = 0 is the road's centre line. `towns.hazard_image` draws them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

LANE = 3.5  # m
CROSS = 8.0  # x of the side street's middle
NEAR, BESIDE = -0.5 * LANE, 0.5 * LANE  # y of the ego's lane and of the one to its left

Line = Sequence[tuple[float, float]]


class Box(NamedTuple):
    """A road user: box centre, heading in degrees, path, size in metres, and colour."""

    x: float
    y: float
    heading: float = 0.0
    path: Line = ()
    size: tuple[float, float] = (4.6, 1.9)
    colour: Literal["other", "parked", "ego"] = "other"


@dataclass(frozen=True)
class Sketch:
    """Contents of a picture.

    Attributes:
        road: "street", "dual" (two lanes in one direction) or "junction".
        ego: The ego's path.
        others: Other road users.
        lights: Traffic lights: x, y and colour.
    """

    road: Literal["street", "dual", "junction"]
    ego: Line
    others: tuple[Box, ...] = ()
    lights: tuple[tuple[float, float, Literal["green", "red"]], ...] = ()


def person(x: float, y: float, heading: float, path: Line) -> Box:
    """Return a pedestrian or cyclist."""
    return Box(x, y, heading, path, (1.0, 1.0))


def _bend(corner: tuple[float, float], radius: float, start: float, end: float) -> Line:
    angles = np.radians(np.linspace(start, end, 16))
    return [(corner[0] + radius * np.cos(a), corner[1] + radius * np.sin(a)) for a in angles]


# Paths of the ego
AHEAD = ((-14.0, NEAR), (32.0, NEAR))
STOPS = ((-14.0, NEAR), (4.0, NEAR))
RIGHT = (AHEAD[0], *_bend((2.0, -6.0), 4.25, 90.0, 0.0), (6.25, -15.0))
LEFT = (AHEAD[0], *_bend((1.5, 6.5), 8.25, -90.0, 0.0), (9.75, 15.0))
WAVES = tuple(
    (x, NEAR + 1.1 * np.sin(x / 3.5) * (0.0 < x < 22.0)) for x in np.linspace(-14, 32, 90)
)
# Other road users
NORTHWARD = Box(9.75, -12.0, 90.0, ((9.75, -9.0), (9.75, 15.0)))
