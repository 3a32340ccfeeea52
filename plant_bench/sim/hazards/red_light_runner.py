"""A red-light runner (CARLA type 7): a vehicle ignores its red while the ego has green."""

import math

from plant_bench.sim.hazards.approach import Approach
from plant_bench.sim.hazards.meeting import Meeting
from plant_bench.world.route import Passage

SIDEWAYS = math.radians(45.0)  # from the ego's heading, at which a street is a cross street


class RedLightRunner(Meeting):
    """A vehicle from a cross street that goes on or left through its red; mutable."""

    def fits(self, way: Approach, passage: Passage) -> bool:
        """Tell whether a way crosses the ego's from a cross street."""
        crosses = SIDEWAYS < abs(way.angle) < math.pi - SIDEWAYS
        return passage.signal is not None and crosses and way.link.turn != "right"
