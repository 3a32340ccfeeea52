"""The highest speed from which all speed limits ahead can be met."""

import functools

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.world.driver_braking import CURVE_BRAKING


def allowed_speed(route: RouteAhead) -> float:
    """Return the highest speed from which comfortable braking meets all limits ahead, m/s."""
    limits = route.speed_limits
    return float(np.sqrt((limits * limits + _braked_square(len(limits))).min()))


@functools.cache
def _braked_square(count: int) -> Float[np.ndarray, " points"]:
    """Return by how much braking can reduce the squared speed up to each point, m2/s2."""
    return 2.0 * CURVE_BRAKING * np.maximum(np.arange(count) - 1.0, 0.0)
