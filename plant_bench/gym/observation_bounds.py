"""Finite bounds of observation spaces, larger than all values that occur."""

from typing import Any

import numpy as np
from gymnasium import spaces

from plant_bench.agent import ROUTE_AHEAD

FASTEST = 60.0  # m/s, above any speed limit
LONGEST = 30.0  # m, longer than any vehicle
ROUTE_REACH = float(ROUTE_AHEAD + 40)  # m: the ego may be up to 30 m away from the route


def box(low: float, high: float, size: int) -> spaces.Box:
    """Return a space of `size` numbers."""
    return spaces.Box(low, high, (size,), np.float32)


def in_bounds(parts: dict[str, spaces.Space[Any]], values: dict[str, Any]) -> dict[str, Any]:
    """Return the values, clipped to the bounds of boxes."""
    boxes = {name: box for name, box in parts.items() if isinstance(box, spaces.Box)}
    return {
        name: np.clip(value, boxes[name].low, boxes[name].high) if name in boxes else value
        for name, value in values.items()
    }
