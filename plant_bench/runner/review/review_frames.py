"""Data of a postmortem: the ticks around infractions, with planner's and expert's decisions."""

from dataclasses import dataclass

from plant_bench.agent import Control, Observation, Plan
from plant_bench.runner.decisions import Decision
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route
from plant_bench.world.scene import EgoState, Scene


@dataclass(frozen=True, slots=True)
class Window:
    """A part of an episode to look at.

    Attributes:
        first: Its first tick.
        last: Its last tick.
        ranked_from: The tick from which on the planner is asked who matters; may be an earlier one.
    """

    first: int
    last: int
    ranked_from: int

    def __contains__(self, tick: int) -> bool:
        return self.first <= tick <= self.last


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """One tick.

    Attributes:
        scene: As recorded.
        seen: What a planner with all inputs but the privileged is given of it.
        control: What was executed from here on.
        plan: The recorded plan in force; None for planners that answer with controls.
        planned_at: The ego when that plan was made.
        planner: The planner's last answer, asked again; None where it could not be.
        expert: The expert's last answer; None where the scenes differ.
    """

    scene: Scene
    seen: Observation
    control: Control
    plan: Plan | None
    planned_at: EgoState
    planner: Decision | None
    expert: Decision | None


@dataclass(frozen=True, eq=False)
class Postmortem:
    """An episode that was looked at again.

    Attributes:
        result: Its record.
        route: The route it was driven on.
        moments: By tick: those of the windows.
        ticks: How many scenes were simulated again and compared.
        difference: In what the first scene that is another differs; empty where all are equal.
        differs_at: Its tick; None where all are equal.
        planner_note: Why the planner's ranking is not there (from some tick on); empty if it is.
        ranked_itself: Whether the ranking is the planner's own; else it is by masking.
        expert_note: Why the expert's answers end before the scenes differ; empty if they do not.
    """

    result: EpisodeResult
    route: Route
    moments: dict[int, Moment]
    ticks: int
    difference: str
    differs_at: int | None
    planner_note: str
    ranked_itself: bool
    expert_note: str

    def between(self, window: Window) -> list[Moment]:
        """Return the moments of a window, in order."""
        return [
            self.moments[tick]
            for tick in range(window.first, window.last + 1)
            if tick in self.moments
        ]
