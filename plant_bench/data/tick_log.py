"""In-memory log of an episode's ticks, kept until the recording is written."""

from dataclasses import dataclass, field

from plant_bench.agent import Control, Plan, Reason
from plant_bench.world.scene import Scene

Action = Plan | Control | None


@dataclass(slots=True)
class Ticks:
    """The ticks of one episode, one item per tick in each list; mutable.

    Attributes:
        every: Ticks between rows with actors and lights.
        scenes: The scenes.
        actions: The agent's actions; None if it made no decision.
        reasons: The agent's reasons; None if it gave none.
        disturbed: Whether an action other than the agent's was executed.
    """

    every: int = 1
    scenes: list[Scene] = field(default_factory=list)
    actions: list[Action] = field(default_factory=list)
    reasons: list[Reason | None] = field(default_factory=list)
    disturbed: list[bool] = field(default_factory=list)
