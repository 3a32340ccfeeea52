"""How far beside the ego's path a crossing hazard must start, so that a driver can still stop.

Both the placement of crossing hazards and their behaviour use this.
"""

from plant_bench.world.driver_braking import BRAKING, REACTION
from plant_bench.world.scene import EGO_WIDTH

WALKER_LENGTH, RIDER_LENGTH = 0.5, 1.8  # m
FARTHEST_START = 9.0  # m beside the ego's path, unless the road is wider
SPEED_SPREAD = 0.1  # relative variation of speed between repetitions
LEFT_OVER = 1.5  # m left when a driver at the speed limit has stopped
TIME_SPARE = 1.15  # factor on the required time


def meets_at(length: float) -> float:
    """Return the lateral distance of a crossing actor's centre at first contact, metres."""
    return 0.5 * EGO_WIDTH + 0.5 * length


def needed_start(speed: float, limit: float, length: float) -> float:
    """Return how far beside the path a crossing must start to be avoidable, metres.

    The time from first sight to contact must suffice for a driver with reaction time at the speed
    limit.

    Args:
        speed: Speed of the crossing actor, m/s.
        limit: The ego's speed limit, m/s.
        length: Length of the crossing actor, metres.
    """
    needed = REACTION + limit / (2.0 * BRAKING) + LEFT_OVER / max(limit, 1.0)
    return meets_at(length) + speed * needed * TIME_SPARE
