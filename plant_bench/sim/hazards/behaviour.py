"""What a hazard's script is: the small protocol that every kind's module keeps."""

import random
from typing import Protocol, runtime_checkable

from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.scene import EgoState


@runtime_checkable
class HazardBehaviour(Protocol):
    """One hazard in motion; mutable. Made when the ego comes near, asked at every tick.

    A script goes from ARMED (it prepares: its actors are out, it adapts to the ego) to COMMITTED
    (it takes its course whatever the ego does) to DONE, or to VOID where it cannot be fair: the
    spot is taken, or a driver at the posted speed could not avoid it any more. It takes back all
    that it put out when it is done.

    Attributes:
        phase: How far it has come.
        reason: Why it is void.
    """

    phase: Phase
    reason: str

    def __init__(self, hazard: Hazard, stage: HazardWorld, draw: random.Random) -> None:
        """Prepare; nothing is put out yet."""
        ...

    def step(self, ego: EgoState, stage: HazardWorld) -> None:
        """Go on by one tick."""
        ...


class HoldsTraffic:
    """The part shared by scripts whose vehicles wait for the ego while they are ARMED; mutable."""

    phase: Phase
    reason: str

    def let_go(self, stage: HazardWorld) -> None:
        """Give all vehicles under command back to the traffic."""
        raise NotImplementedError

    def end(self, stage: HazardWorld, phase: Phase, reason: str = "") -> None:
        """Let the vehicles go, and end as DONE or VOID."""
        self.let_go(stage)
        self.phase, self.reason = phase, reason


def number_of(hazard: Hazard, name: str, draw: random.Random) -> float:
    """Return a parameter of a hazard; one that it does not have is drawn from its kind's range."""
    drawn = draw.uniform(*HAZARDS[hazard.kind].ranges[name])
    return hazard.parameters.get(name, drawn)
