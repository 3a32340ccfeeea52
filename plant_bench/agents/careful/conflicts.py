"""Which accelerations keep clear of the forecast boxes of others."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agents.careful.box_overlaps import first_overlaps
from plant_bench.agents.careful.forecast import TIMES, Forecast
from plant_bench.world.scene import EGO_EXTENT

MARGIN_ASIDE = 0.25  # m on each side of others
TOUCHING = 0.3  # share of the margins within which others are as good as touched
_EXTENT = np.array(EGO_EXTENT)


class Conflicts(NamedTuple):
    """The first overlap that each choice runs into.

    Attributes:
        times: Seconds; infinite for none.
        actors: Whose box it is, a row of the forecast; -1 for none.
    """

    times: Float[np.ndarray, " choices"]
    actors: Int[np.ndarray, " choices"]


def first_conflicts(
    poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast, boldness: float
) -> Conflicts:
    """Return for each choice the first overlap within the margins; of several, the nearest box.

    Args:
        poses: The ego's poses, one row a choice.
        forecast: The others.
        boldness: 0 keeps the full margins, 1 none towards who stands.
    """
    return _first(poses, forecast, boldness, 1.0)


def clearest(
    poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast, boldness: float
) -> int:
    """Return the gentlest braking that keeps the margins, else going on if that keeps them.

    Where nothing keeps them, it is the hardest braking that does not touch, else what touches last.

    Args:
        poses: The ego's poses for going on, the first row, and for ever harder braking.
        forecast: The others.
        boldness: As of `first_conflicts`.
    """
    clear = np.flatnonzero(first_conflicts(poses, forecast, boldness).times == math.inf)
    if clear.size:
        return int(clear[min(clear.size - 1, int(clear[0] == 0))])
    times = _first(poses, forecast, boldness, TOUCHING).times
    return len(times) - 1 - int(np.argmax(times[::-1]))


def _first(
    poses: Float[np.ndarray, "choices steps 3"],
    forecast: Forecast,
    boldness: float,
    caution: float,
) -> Conflicts:
    """Return the first overlaps with a share of the margins kept."""
    shares = caution * np.where(forecast.standing, 1.0 - boldness, 1.0)
    boxes = forecast.poses, forecast.lengths, forecast.widths, forecast.margins
    steps, actors = first_overlaps(poses, _EXTENT, *boxes, shares, MARGIN_ASIDE)
    return Conflicts(np.where(steps < 0, math.inf, TIMES[steps]), actors)
