"""Events that a training reports to its listener."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StepEnded:
    """A step has ended.

    Attributes:
        epoch: The epoch, from 0.
        step: Number of finished steps of the epoch.
        steps: Number of steps of the epoch.
        loss: The minimised loss.
        waited: Time spent waiting for the batch, seconds.
    """

    epoch: int
    step: int
    steps: int
    loss: float
    waited: float = 0.0


@dataclass(frozen=True, slots=True)
class EpochEnded:
    """An epoch has ended.

    Attributes:
        epoch: The epoch, from 0.
        row: Its row of the history.
    """

    epoch: int
    row: dict[str, float]


@dataclass(frozen=True, slots=True)
class Driving:
    """A closed-loop validation starts."""

    epoch: int


TrainingEvent = StepEnded | EpochEnded | Driving
Listener = Callable[[TrainingEvent], None]
