"""The table of rewards by name, and the progress reward. See docs/reference/gymnasium.md."""

from plant_bench.errors import InputError
from plant_bench.gym.roach import RoachReward
from plant_bench.gym.transition import Reward, Transition


class ProgressReward:
    """Route progress in metres minus the cost of infractions, similar to the driving score.

    Args:
        lost: Cost in metres of an infraction with penalty factor 0. An infraction costs `lost`
            times one minus its factor (`plant_bench.scoring.infractions.PENALTIES`): half of `lost`
            for a collision with a pedestrian.
    """

    def __init__(self, lost: float = 100.0) -> None:
        self._lost = lost

    def __call__(self, transition: Transition) -> dict[str, float]:
        """Return progress, progress outside the lanes (negative), and penalties, metres."""
        costs = sum(1.0 - item.factor for item in transition.infractions if item.share is None)
        return {
            "progress": transition.progress,
            "outside": -transition.outside,
            "infractions": -self._lost * costs,
        }


REWARDS: dict[str, type[RoachReward] | type[ProgressReward]] = {
    "roach": RoachReward,
    "progress": ProgressReward,
}


def reward_of(reward: object) -> Reward:
    """Return a reward by its name; a reward object is returned as it is.

    Raises:
        InputError: There is no reward of this name, or the object is not callable.
    """
    if isinstance(reward, str):
        if reward not in REWARDS:
            message = f"There is no reward {reward!r}. Rewards: {', '.join(REWARDS)}."
            raise InputError(message)
        return REWARDS[reward]()
    if not isinstance(reward, Reward):
        message = f"Reward: expected a name or a function of a Transition, got {reward!r}."
        raise InputError(message)
    return reward
