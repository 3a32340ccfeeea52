"""How a surprised driver stops: the measure of what is avoidable, and of whom one steps before."""

import math

from plant_bench.world.scene import EgoState

REACTION = 0.5  # s, of a driver who is surprised
BRAKING = 4.0  # m/s2, of the same driver
SPARE = 1.0  # m that are left over when a hazard is called avoidable


def stopping_distance(ego: EgoState, limit: float = math.inf) -> float:
    """Return the metres that an ego needs to stop if its driver is surprised now.

    While it reacts it goes on gaining speed as before, up to the limit; then it brakes.

    Args:
        ego: The ego.
        limit: m/s; a faster ego keeps its speed.
    """
    after = min(ego.speed + max(ego.acceleration, 0.0) * REACTION, max(limit, ego.speed))
    return REACTION * 0.5 * (ego.speed + after) + after**2 / (2.0 * BRAKING)
