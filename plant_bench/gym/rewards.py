"""The environment's rewards by name; docs/reference/gymnasium.md has the table."""

from plant_bench.errors import InputError
from plant_bench.gym.roach import RoachReward
from plant_bench.gym.transition import Reward, Transition


class ProgressReward:
    """Metres of route driven, less the costs of infractions, as in the driving score.

    Args:
        lost: Cost of an infraction in metres, to be multiplied by one minus its factor
            (`plant_bench.scoring.infractions.PENALTIES`): 0.5 for hitting a pedestrian.
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
    """Return a reward by its name, or the given reward.

    Raises:
        InputError: There is none of this name, or it cannot be called.
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
