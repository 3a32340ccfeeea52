"""Rewards: what a step was worth, as named terms that add up. docs/gymnasium.md has the table."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from plant_bench.agent import Control, Observation
from plant_bench.errors import InputError
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
        """Return the terms by name: the reward is their sum, and `info["reward"]` holds them."""
        ...


class ProgressReward:
    """Metres of route, less what infractions cost: the score's own terms.

    Args:
        lost: Metres that an infraction costs if it halves the score twice over, that is times one
            minus its factor (`plant_bench.scoring.infractions.PENALTIES`): a pedestrian hit costs
            half of it.
    """

    def __init__(self, lost: float = 100.0) -> None:
        self._lost = lost

    def __call__(self, transition: Transition) -> dict[str, float]:
        """Return metres gained, metres not counted since outside the lanes, and penalties."""
        costs = sum(1.0 - item.factor for item in transition.infractions if item.share is None)
        return {
            "progress": transition.progress,
            "outside": -transition.outside,
            "infractions": -self._lost * costs,
        }


def reward_of(wanted: str | Reward) -> Reward:
    """Return a reward by its name, or the one given.

    Raises:
        InputError: There is none of this name, or it cannot be called.
    """
    from plant_bench.gym.roach import RoachReward  # which is made of this module's values

    rewards = {"roach": RoachReward, "progress": ProgressReward}
    if isinstance(wanted, str):
        if wanted not in rewards:
            message = f"There is no reward {wanted!r}. Rewards: {', '.join(rewards)}."
            raise InputError(message)
        return rewards[wanted]()
    if not callable(wanted):
        message = f"{wanted!r} is no reward: something called with a Transition, or a name."
        raise InputError(message)
    return wanted
