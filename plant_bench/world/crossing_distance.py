"""From where somebody crosses the ego's path, so that a surprised driver can stop.

Placing a crossing on a route and playing it both go by this.
"""

from plant_bench.world.driver_braking import BRAKING, REACTION
from plant_bench.world.scene import EGO_WIDTH

WALKER_LENGTH, RIDER_LENGTH = 0.5, 1.8  # m
FARTHEST_START = 9.0  # m beside the ego's path, unless the road is wider
SPEED_SPREAD = 0.1  # share by which repetitions differ in speed
LEFT_OVER = 1.5  # m that are left when a driver at the speed limit has stopped
TIME_SPARE = 1.15  # times the time that is needed


def meets_at(length: float) -> float:
    """Return how far beside the ego's path the middle of one who comes is when the boxes touch."""
    return 0.5 * EGO_WIDTH + 0.5 * length


def needed_start(speed: float, limit: float, length: float) -> float:
    """Return how far beside the path a crossing must start to be survivable, metres.

    The time from first sight to the meeting must be enough for a surprised driver at the speed
    limit.

    Args:
        speed: Of who crosses, m/s.
        limit: The ego's speed limit, m/s.
        length: Of who crosses, metres.
    """
    needed = REACTION + limit / (2.0 * BRAKING) + LEFT_OVER / max(limit, 1.0)
    return meets_at(length) + speed * needed * TIME_SPARE
