"""Selects the accelerations that keep the ego clear of the forecast boxes."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agents.careful.box_overlaps import first_overlaps
from plant_bench.agents.careful.forecast import TIMES, Forecast
from plant_bench.world.scene import EGO_EXTENT

SIDE_MARGIN = 0.25  # m on each side of other actors
CONTACT_SHARE = 0.3  # share of the margins within which an overlap counts as contact
_EXTENT = np.array(EGO_EXTENT)


class Conflicts(NamedTuple):
    """The first overlap of each choice.

    Attributes:
        times: Time of the overlap, seconds; infinite for none.
        actors: Row of the overlapped box in the forecast; -1 for none.
    """

    times: Float[np.ndarray, " choices"]
    actors: Int[np.ndarray, " choices"]


def first_conflicts(
    poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast, margin_reduction: float
) -> Conflicts:
    """Return each choice's first overlap including margins; of several, with the nearest box.

    Args:
        poses: The ego's poses, one row per choice.
        forecast: The other actors.
        margin_reduction: 0 keeps the full margins, 1 keeps none from stationary actors.
    """
    return _first(poses, forecast, margin_reduction, 1.0)


def best_choice(
    poses: Float[np.ndarray, "choices steps 3"], forecast: Forecast, margin_reduction: float
) -> int:
    """Return the gentlest braking that keeps the margins, else continuing if that keeps them.

    If nothing keeps them: the hardest braking without contact, else the latest contact.

    Args:
        poses: The ego's poses if it continues (first row), and for ever harder braking.
        forecast: The other actors.
        margin_reduction: As for `first_conflicts`.
    """
    clear = np.flatnonzero(first_conflicts(poses, forecast, margin_reduction).times == math.inf)
    if clear.size:
        return int(clear[min(clear.size - 1, int(clear[0] == 0))])
    times = _first(poses, forecast, margin_reduction, CONTACT_SHARE).times
    return len(times) - 1 - int(np.argmax(times[::-1]))


def _first(
    poses: Float[np.ndarray, "choices steps 3"],
    forecast: Forecast,
    margin_reduction: float,
    margin_share: float,
) -> Conflicts:
    """Return the first overlaps with a share of the margins."""
    shares = margin_share * np.where(forecast.standing, 1.0 - margin_reduction, 1.0)
    boxes = forecast.poses, forecast.lengths, forecast.widths, forecast.margins
    steps, actors = first_overlaps(poses, _EXTENT, *boxes, shares, SIDE_MARGIN)
    return Conflicts(np.where(steps < 0, math.inf, TIMES[steps]), actors)
