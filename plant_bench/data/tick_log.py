"""The ticks of an episode as they are kept while it drives."""

from dataclasses import dataclass, field

from plant_bench.agent import Control, Plan, Reason
from plant_bench.world.scene import Scene

Action = Plan | Control | None


@dataclass(slots=True)
class Ticks:
    """The ticks of one episode, an item each in all of the lists; mutable.

    Attributes:
        every: Actors and lights are kept at every so many ticks alone.
        scenes: What there was.
        actions: What the agent answered to it; None where it was not asked.
        reasons: Why, where it told.
        disturbed: Whether something else than the answer was executed.
    """

    every: int = 1
    scenes: list[Scene] = field(default_factory=list)
    actions: list[Action] = field(default_factory=list)
    reasons: list[Reason | None] = field(default_factory=list)
    disturbed: list[bool] = field(default_factory=list)
