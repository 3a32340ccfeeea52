"""An unsignalled crossing (CARLA type 10): a vehicle arrives with the ego and takes its way."""

from plant_bench.sim.hazards.approach import Approach
from plant_bench.sim.hazards.meeting import Meeting
from plant_bench.world.route import Passage


class UnsignalledCrossing(Meeting):
    """A vehicle that goes first, with or without the right of way; mutable."""

    def fits(self, way: Approach, passage: Passage) -> bool:
        """Tell whether a way meets the ego's where no signal rules."""
        return passage.signal is None and way.link.signal is None
