"""The speed that the limits ahead allow."""

import functools

import numpy as np
from jaxtyping import Float

from plant_bench.agent import RouteAhead
from plant_bench.world.driver_braking import CURVE_BRAKING


def allowed_speed(route: RouteAhead) -> float:
    """Return the speed from which all limits ahead are met with comfortable braking, m/s."""
    limits = route.speed_limits
    return float(np.sqrt((limits * limits + _shed(len(limits))).min()))


@functools.cache
def _shed(count: int) -> Float[np.ndarray, " points"]:
    """Return the square of the speed that is braked away up to each point."""
    return 2.0 * CURVE_BRAKING * np.maximum(np.arange(count) - 1.0, 0.0)
