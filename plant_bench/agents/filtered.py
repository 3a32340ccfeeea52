"""A planner that is shown only the actors that rank highest (PlanT, section 4.2: RFDS)."""

import numpy as np

from plant_bench.agent import (
    Agent,
    Control,
    Explains,
    Input,
    Observation,
    Plan,
    Ranker,
    Reason,
    decision_interval,
)
from plant_bench.errors import AgentError
from plant_bench.world.route import Route


class Filtered:
    """Drives as another planner would that sees only who matters most to a ranker.

    The ego, the route and the light stay in view. A ranker that is a planner itself is reset with
    the route and given its own inputs, of all actors; its actions are never asked for.

    Args:
        agent: Who drives.
        ranker: Who tells which actors matter.
        most: How many of them are shown.

    Raises:
        AgentError: The agent takes no objects, or `most` is negative.
    """

    def __init__(self, agent: Agent, ranker: Ranker, most: int = 1) -> None:
        if Input.OBJECTS not in agent.inputs or most < 0:
            message = (
                f"Filtered({type(agent).__name__}, most={most}): a planner with the input "
                "'objects' is wanted, and a number of actors from 0."
            )
            raise AgentError(message)
        self._agent, self._ranker, self._most = agent, ranker, most
        own = ranker.inputs if isinstance(ranker, Agent) else frozenset({Input.OBJECTS})
        self._ranker_inputs = own
        self.inputs = agent.inputs | own

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return decision_interval(self._agent)

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        for member in (self._agent, self._ranker):
            if isinstance(member, Agent):
                member.reset(route if Input.ROUTE in member.inputs else None)

    def act(self, observation: Observation) -> Plan | Control:
        """Rank all actors, and let the planner decide with the first of them."""
        seen = observation.given(self._agent.inputs)
        if seen.actors is None:
            message = "A filtered planner needs the input 'objects'."
            raise AgentError(message)
        ranks = self._ranker.rank(observation.given(self._ranker_inputs))
        return self._agent.act(seen.showing(highest(ranks, seen.actors.ids, self._most)))

    def explain(self) -> Reason | None:
        """Return the planner's reason, if it tells."""
        return self._agent.explain() if isinstance(self._agent, Explains) else None


def highest(ranks: np.ndarray, ids: np.ndarray, most: int) -> np.ndarray:
    """Return the places of the actors that rank highest, in their order; ties go to lower ids.

    Args:
        ranks: One for each actor.
        ids: Of the actors.
        most: How many are wanted.

    Raises:
        AgentError: There is not one finite rank for each actor.
    """
    if ranks.shape != ids.shape or not np.isfinite(ranks).all():
        message = f"rank returned shape {ranks.shape}: {ids.shape} finite values are wanted."
        raise AgentError(message)
    return np.sort(np.lexsort((ids, -ranks))[:most])
