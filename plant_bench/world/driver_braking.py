"""Stopping distance with reaction time, shared by hazards, pedestrians and planners.

A hazard is avoidable if a driver with this reaction time and braking could still stop; pedestrians
do not step in front of drivers who could not.
"""

import math

from plant_bench.world.scene import EgoState

REACTION = 0.5  # s, reaction time
BRAKING = 4.0  # m/s2, of the same driver
SPARE = 1.0  # m left after stopping, for a hazard that counts as avoidable
GRIP = 0.6  # share of acceleration and braking left during a control loss
CURVE_BRAKING = 1.8  # m/s2 towards a bend or a lower speed limit ahead


def stopping_distance(ego: EgoState, limit: float = math.inf) -> float:
    """Return the stopping distance of an ego with reaction time, metres.

    During the reaction time it keeps accelerating as before, up to the limit; then it brakes.

    Args:
        ego: The ego.
        limit: Speed limit, m/s; a faster ego keeps its speed.
    """
    after = min(ego.speed + max(ego.acceleration, 0.0) * REACTION, max(limit, ego.speed))
    return REACTION * 0.5 * (ego.speed + after) + after**2 / (2.0 * BRAKING)
