"""Data of a postmortem: the ticks around infractions, with planner's and expert's decisions."""

from dataclasses import dataclass

from plant_bench.agent import Control, Observation, Plan, Reason
from plant_bench.runner.decisions import Decision
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route
from plant_bench.world.scene import EgoState, Scene


@dataclass(frozen=True, slots=True)
class Window:
    """A range of ticks of an episode.

    Attributes:
        first: First tick.
        last: Last tick, inclusive.
        ranked_from: First tick at which the planner's actor ranking is queried; may precede
            `first`.
    """

    first: int
    last: int
    ranked_from: int

    def __contains__(self, tick: int) -> bool:
        return self.first <= tick <= self.last


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """One tick of a postmortem.

    Attributes:
        scene: The recorded scene.
        seen: Observation with all inputs except the privileged ones.
        control: The control executed at this tick.
        plan: The latest recorded plan; None for planners that return controls.
        planned_at: State of the ego when that plan was made.
        planner: The planner's latest decision in shadow mode; None if it cannot be queried.
        expert: The expert's latest decision in shadow mode; None if it cannot be queried.
        reason: The latest recorded reason of the planner; None if it gave none.
    """

    scene: Scene
    seen: Observation
    control: Control
    plan: Plan | None
    planned_at: EgoState
    planner: Decision | None
    expert: Decision | None
    reason: Reason | None = None


@dataclass(frozen=True, eq=False)
class Postmortem:
    """The review of one episode.

    Attributes:
        result: The episode's record.
        route: The route it was driven on.
        moments: Moments of the windows by tick.
        ticks: Number of scenes that were simulated again and compared.
        difference: How the first differing scene differs; empty if all scenes are equal.
        differs_at: Tick of that scene; None if all scenes are equal.
        planner_note: Why the planner was not queried, or only up to some tick; empty if it was.
        ranked_itself: Whether the ranking comes from the planner's `rank`; else from masking.
        expert_note: Why the expert was not queried, or only up to some tick; empty if it was.
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
