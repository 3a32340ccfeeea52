"""The Intelligent Driver Model (IDM), also for stop lines and traffic lights."""

import math

from plant_bench.agent import NextLight
from plant_bench.world.scene import Light

IDM_ACCELERATION = 2.5  # m/s2
IDM_BRAKING = 3.0  # m/s2, comfortable
IDM_HEADWAY = 1.0  # s (Treiber, Hennecke, Helbing 2000 use 1.6; 1.0 is SUMO's own default)
IDM_STANDSTILL = 2.5  # m, SUMO's default minGap
HARDEST_BRAKING = 8.0  # m/s2

YELLOW_BRAKING = 3.5  # m/s2; stop at yellow unless that needs harder braking


def idm(speed: float, target: float, gap: float = math.inf, leader_speed: float = 0.0) -> float:
    """Return the acceleration of the Intelligent Driver Model, m/s2.

    Args:
        speed: The vehicle's speed, m/s.
        target: Desired speed on a free road, m/s.
        gap: Distance to the leader, bumper to bumper, metres.
        leader_speed: The leader's speed, m/s.
    """
    free = 1.0 - (speed / max(target, 0.1)) ** 4
    if gap == math.inf:
        return max(IDM_ACCELERATION * free, -IDM_BRAKING)
    dynamic = speed * (speed - leader_speed) / (2.0 * math.sqrt(IDM_ACCELERATION * IDM_BRAKING))
    desired_gap = IDM_STANDSTILL + max(0.0, speed * IDM_HEADWAY + dynamic)
    acceleration = IDM_ACCELERATION * (free - (desired_gap / max(gap, 0.1)) ** 2)
    return max(acceleration, -HARDEST_BRAKING)


def stop_within(speed: float, distance: float) -> float:
    """Return the acceleration that stops at a line `distance` metres ahead of the bumper, m/s2."""
    return idm(speed, 100.0, distance + IDM_STANDSTILL - 0.8, 0.0)


def light_limit(speed: float, light: NextLight | None) -> float:
    """Return the highest acceleration that a traffic light allows, m/s2."""
    if light is None or light.state in (Light.GREEN, Light.UNKNOWN):
        return math.inf
    if light.distance < -1.0:
        return math.inf
    distance = max(light.distance, 0.1)
    needed = speed * speed / (2.0 * distance)
    if light.state is Light.YELLOW and needed > YELLOW_BRAKING:
        return math.inf
    return stop_within(speed, distance)
