"""Which actors matter to a planner at one moment of an episode, as it says itself or by masking."""

import copy

import numpy as np

from plant_bench.agent import Agent, Observation, Ranker
from plant_bench.agents.ranking.masking import Masking
from plant_bench.runner.decisions import call_planner


def ranking_before(agent: Agent, seen: Observation) -> tuple[int, ...] | None:
    """Return the ids of the actors in sight, the most relevant first, before a planner decides.

    A copy of the planner is asked, so that it does not notice; None where it cannot be copied or is
    shown no actors. One that has no `rank` is asked by masking: who changes nothing is no part of
    that ranking.

    Raises:
        AgentError: The planner fails.
    """
    actors = seen.actors
    if actors is None:
        return None
    try:
        other = copy.deepcopy(agent)
    except Exception:  # noqa: BLE001  whatever a planner holds that cannot be copied
        return None
    if not len(actors):
        return ()
    itself = isinstance(other, Ranker)
    ranks = relevance_of(other if itself else Masking(other), seen)
    order = np.lexsort((actors.ids, -ranks))
    return tuple(int(actors.ids[place]) for place in order if itself or ranks[place] > 0.0)


def relevance_of(ranker: Ranker, seen: Observation) -> np.ndarray:
    """Return the relevance of each actor in sight, as a ranker tells it.

    Raises:
        AgentError: It raised something.
    """
    return np.asarray(call_planner("rank", ranker.rank, seen))
