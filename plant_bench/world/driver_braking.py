"""How drivers brake: the numbers that placing and playing hazards, planners and people share.

A hazard is avoidable if a surprised driver could still stop; nobody steps in front of one who could
not.
"""

import math

from plant_bench.world.scene import EgoState

REACTION = 0.5  # s, of a driver who is surprised
BRAKING = 4.0  # m/s2, of the same driver
SPARE = 1.0  # m that are left over when a hazard is called avoidable
GRIP = 0.6  # share of acceleration and braking that a control loss leaves
CURVE_BRAKING = 1.8  # m/s2 towards a bend or a lower speed limit ahead


def stopping_distance(ego: EgoState, limit: float = math.inf) -> float:
    """Return the metres that an ego needs to stop if its driver is surprised now.

    While it reacts it goes on gaining speed as before, up to the limit; then it brakes.

    Args:
        ego: The ego.
        limit: m/s; a faster ego keeps its speed.
    """
    after = min(ego.speed + max(ego.acceleration, 0.0) * REACTION, max(limit, ego.speed))
    return REACTION * 0.5 * (ego.speed + after) + after**2 / (2.0 * BRAKING)
