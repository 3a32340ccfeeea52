"""A right turn into crossing traffic (CARLA type 9): a vehicle from the left takes the same lane.

At a signal it runs its red; at a minor road it has the right of way and insists on it.
"""

import math

from plant_bench.sim.hazards.approach import Approach
from plant_bench.sim.hazards.meeting import Meeting
from plant_bench.world.route import Passage

FROM_LEFT = math.radians(-90.0)  # the heading of a vehicle from the left, from the ego's
SPREAD = math.radians(50.0)


class RightTurn(Meeting):
    """A vehicle that goes where the ego turns to; mutable."""

    def fits(self, way: Approach, passage: Passage) -> bool:
        """Tell whether a way leads from the left into the lane that the ego turns to."""
        from_left = abs(way.angle - FROM_LEFT) < SPREAD
        return passage.turn == "right" and from_left and way.link.turn == "straight"
