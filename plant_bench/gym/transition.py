"""What a reward is made of: one step of the environment."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from plant_bench.agent import Control, Observation
from plant_bench.scoring.infractions import Infraction, Status
from plant_bench.world.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Transition:
    """One step of the environment.

    Attributes:
        before: What there was when the action was chosen.
        after: What there is now.
        observation: As a planner is given `after`: also the route ahead and the next light.
        control: What the vehicle was asked for.
        last_control: In the step before; nothing in the first.
        progress: Metres driven along the route in this step.
        outside: Metres of these driven outside the lanes or against their direction.
        infractions: Noted in this step.
        status: How the episode has ended, None while it goes on.
    """

    before: Scene
    after: Scene
    observation: Observation
    control: Control
    last_control: Control
    progress: float
    outside: float
    infractions: tuple[Infraction, ...]
    status: Status | None


@runtime_checkable
class Reward(Protocol):
    """Values a step."""

    def __call__(self, transition: Transition) -> dict[str, float]:
        """Return the terms by name: `info["reward_terms"]`; the reward is their sum."""
        ...
