"""Ranks actors by relevance to a planner at one tick, by its `rank` method or by masking."""

import copy

import numpy as np

from plant_bench.agent import Agent, Observation, Ranker
from plant_bench.agents.ranking.masking import Masking
from plant_bench.runner.decisions import call_planner


def rank_actors(agent: Agent, observation: Observation) -> tuple[int, ...] | None:
    """Return the ids of the observed actors, the most relevant first; to be called before `act`.

    A copy of the planner is queried, so that its state does not change. A planner without `rank` is
    ranked by masking, which leaves out actors that do not change its action.

    Returns:
        None if the planner cannot be copied or its observation has no actors.

    Raises:
        AgentError: The planner fails.
    """
    actors = observation.actors
    if actors is None:
        return None
    try:
        duplicate = copy.deepcopy(agent)
    except Exception:  # noqa: BLE001  a planner may hold any object that cannot be copied
        return None
    if not len(actors):
        return ()
    has_rank = isinstance(duplicate, Ranker)
    ranks = relevance_of(duplicate if has_rank else Masking(duplicate), observation)
    order = np.lexsort((actors.ids, -ranks))
    return tuple(int(actors.ids[row]) for row in order if has_rank or ranks[row] > 0.0)


def relevance_of(ranker: Ranker, observation: Observation) -> np.ndarray:
    """Return the relevance of each observed actor.

    Raises:
        AgentError: The ranker raised an exception.
    """
    return np.asarray(call_planner("rank", ranker.rank, observation))
