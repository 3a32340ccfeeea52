"""Events that a training reports to its listener."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StepEnded:
    """A step is done; `loss` is what it minimised, `waited` how many seconds for its batch."""

    epoch: int
    step: int
    steps: int
    loss: float
    waited: float = 0.0


@dataclass(frozen=True, slots=True)
class EpochEnded:
    """An epoch is done; `row` is its line in the history."""

    epoch: int
    row: dict[str, float]


@dataclass(frozen=True, slots=True)
class Driving:
    """A closed-loop validation begins."""

    epoch: int


TrainingEvent = StepEnded | EpochEnded | Driving
Listener = Callable[[TrainingEvent], None]
