"""The interface of a reward, and its input: one step of the environment."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from plant_bench.agent import Control, Observation
from plant_bench.scoring.infractions import Infraction, Status
from plant_bench.world.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Transition:
    """One step of the environment.

    Attributes:
        before: The scene when the action was chosen.
        after: The scene now.
        observation: The observation of `after`, with the route ahead and the next light.
        control: The executed control.
        last_control: The control of the previous step; zero in the first.
        progress: Distance driven along the route in this step, metres.
        outside: Distance driven outside the lanes or against their direction, metres.
        infractions: The infractions in this step.
        status: How the episode has ended; None while it is running.
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
    """Computes the reward of a step."""

    def __call__(self, transition: Transition) -> dict[str, float]:
        """Return the terms by name: `info["reward_terms"]`; the reward is their sum."""
        ...
