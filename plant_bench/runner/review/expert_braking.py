"""The actors that the expert would brake for, over an episode driven by any planner."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from plant_bench.data.recording import Recording

EXPERT = "expert"


@dataclass(frozen=True, eq=False)
class ExpertView:
    """Whom the expert would brake for, and when.

    Attributes:
        ticks: When it was asked, rising.
        actors: Ids of whom it would brake for; `NO_ACTOR` where no actor decides.
        note: Why it could not be asked, or only up to some time; empty where it was.
    """

    ticks: Int[np.ndarray, " asked"]
    actors: Int[np.ndarray, " asked"]
    note: str = ""


def told_by_expert(recording: Recording) -> ExpertView:
    """Return what the expert told while it drove itself."""
    told = [(row, item.actor) for row, item in enumerate(recording.reasons) if item is not None]
    ticks, actors = np.array(told, int).reshape(-1, 2).T
    return ExpertView(ticks, actors)
