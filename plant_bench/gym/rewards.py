"""The rewards there are; docs/reference/gymnasium.md has the table."""

from plant_bench.errors import InputError
from plant_bench.gym.roach import RoachReward
from plant_bench.gym.transition import Reward, Transition


class ProgressReward:
    """Metres of route, less what infractions cost: the score's own terms.

    Args:
        lost: Metres that an infraction costs, times one minus its factor
            (`plant_bench.scoring.infractions.PENALTIES`): a pedestrian hit costs half of it.
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


REWARDS: dict[str, type[RoachReward] | type[ProgressReward]] = {
    "roach": RoachReward,
    "progress": ProgressReward,
}


def reward_of(wanted: object) -> Reward:
    """Return a reward by its name, or the one given.

    Raises:
        InputError: There is none of this name, or it cannot be called.
    """
    if isinstance(wanted, str):
        if wanted not in REWARDS:
            message = f"There is no reward {wanted!r}. Rewards: {', '.join(REWARDS)}."
            raise InputError(message)
        return REWARDS[wanted]()
    if not isinstance(wanted, Reward):
        message = f"{wanted!r} is no reward: something called with a Transition, or a name."
        raise InputError(message)
    return wanted
