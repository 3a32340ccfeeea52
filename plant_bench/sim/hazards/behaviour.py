"""The protocol that every kind of hazard implements."""

import random
from typing import Protocol, runtime_checkable

from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.scene import EgoState


@runtime_checkable
class HazardBehaviour(Protocol):
    """One active hazard; mutable. Created when the ego comes near, stepped at every tick.

    A hazard goes from ARMED (it spawns its actors and adapts to the ego) to COMMITTED (it runs
    whatever the ego does) to DONE, or to VOID if it would not be fair: the place is occupied, or a
    driver at the posted speed could no longer avoid it. It removes its actors when it ends.

    Attributes:
        phase: Current phase.
        reason: Why it is void; else empty.
    """

    phase: Phase
    reason: str

    def __init__(self, hazard: Hazard, world: HazardWorld, draw: random.Random) -> None:
        """Prepare, without spawning actors."""
        ...

    def step(self, ego: EgoState, world: HazardWorld) -> None:
        """Advance by one tick."""
        ...


class HoldsTraffic:
    """Base of behaviours whose vehicles wait for the ego while ARMED; mutable."""

    phase: Phase
    reason: str

    def let_go(self, world: HazardWorld) -> None:
        """Return all vehicles under command to the traffic."""
        raise NotImplementedError

    def end(self, world: HazardWorld, phase: Phase, reason: str = "") -> None:
        """Release the vehicles, and end as DONE or VOID."""
        self.let_go(world)
        self.phase, self.reason = phase, reason


def parameter_of(hazard: Hazard, name: str, draw: random.Random) -> float:
    """Return a hazard's parameter; if it has none, draw it from the kind's range."""
    drawn = draw.uniform(*HAZARDS[hazard.kind].ranges[name])
    return hazard.parameters.get(name, drawn)
