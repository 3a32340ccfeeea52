"""The actors that the expert would brake for, over an episode driven by any planner."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from plant_bench.data.recording import Recording

EXPERT = "expert"


@dataclass(frozen=True, eq=False)
class ExpertView:
    """The actors that the expert would brake for, by tick.

    Attributes:
        ticks: Ticks at which the expert was queried, ascending.
        actors: Id of the actor it would brake for; `NO_ACTOR` if no actor decides.
        note: Why it was not queried, or only up to some time; empty if it always was.
    """

    ticks: Int[np.ndarray, " queries"]
    actors: Int[np.ndarray, " queries"]
    note: str = ""


def recorded_expert_view(recording: Recording) -> ExpertView:
    """Return the actors that the expert recorded as its reasons while it drove itself."""
    rows = [(row, item.actor) for row, item in enumerate(recording.reasons) if item is not None]
    ticks, actors = np.array(rows, int).reshape(-1, 2).T
    return ExpertView(ticks, actors)
