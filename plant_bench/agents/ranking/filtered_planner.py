"""Runs a planner with only the highest-ranked actors visible (PlanT, section 4.3: RFDS)."""

import numpy as np

from plant_bench.agent import Agent, Control, Explains, Input, Observation, Plan, Ranker, Reason
from plant_bench.agent_check import decision_interval
from plant_bench.errors import AgentError
from plant_bench.sensing.inputs import restrict
from plant_bench.world.route import Route
from plant_bench.world.scene import ActorKind, Actors


class Filtered:
    """Runs a planner that sees only the highest-ranked actors.

    The ego, the route and the light stay visible. A ranker with `inputs` and `reset`, as planners
    have, is reset with the route and gets its inputs with all actors; its `act` is not called.

    Args:
        agent: The planner that drives.
        ranker: The ranker.
        most: Number of visible actors.
        vehicles_only: Filter vehicles alone; pedestrians stay visible, as for PlanT's RFDS.

    Raises:
        AgentError: The planner has no input 'objects', or `most` is negative.
    """

    def __init__(
        self, agent: Agent, ranker: Ranker, most: int = 1, *, vehicles_only: bool = False
    ) -> None:
        if Input.OBJECTS not in agent.inputs or most < 0:
            message = (
                f"Filtered({type(agent).__name__}, most={most}): expected a planner with the input "
                "'objects', and a number of actors from 0."
            )
            raise AgentError(message)
        self._agent, self._ranker, self._most = agent, ranker, most
        self._vehicles_only = vehicles_only
        self._ranker_inputs = inputs_of(ranker)
        self.inputs = agent.inputs | self._ranker_inputs

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return decision_interval(self._agent)

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._agent.reset(route if Input.ROUTE in self._agent.inputs else None)
        reset = getattr(self._ranker, "reset", None)
        if reset is not None:
            reset(route if Input.ROUTE in self._ranker_inputs else None)

    def act(self, observation: Observation) -> Plan | Control:
        """Rank all actors, and return the planner's action with the first of them visible."""
        seen = restrict(observation, self._agent.inputs)
        if seen.actors is None:
            message = "A filtered planner needs the input 'objects'."
            raise AgentError(message)
        ranks = self._ranker.rank(restrict(observation, self._ranker_inputs))
        return self._agent.act(seen.showing(self._shown(ranks, seen.actors)))

    def explain(self) -> Reason | None:
        """Return the planner's reason, if it explains itself."""
        return self._agent.explain() if isinstance(self._agent, Explains) else None

    def _shown(self, ranks: np.ndarray, actors: Actors) -> np.ndarray:
        """Return the rows of the visible actors, in ascending order."""
        if not self._vehicles_only:
            return highest(ranks, actors.ids, self._most)
        check_ranks(ranks, actors.ids)
        shown = actors.kinds == ActorKind.PEDESTRIAN
        places = np.flatnonzero(~shown)
        shown[places[highest(ranks[places], actors.ids[places], self._most)]] = True
        return np.flatnonzero(shown)


def inputs_of(ranker: Ranker) -> frozenset[str]:
    """Return a ranker's inputs: those that it declares, by default the objects."""
    return getattr(ranker, "inputs", frozenset({Input.OBJECTS}))


def highest(ranks: np.ndarray, ids: np.ndarray, most: int) -> np.ndarray:
    """Return the rows of the highest-ranked actors, in ascending order; ties go to lower ids.

    Args:
        ranks: The actors' ranks.
        ids: The actors' ids.
        most: Number of actors.

    Raises:
        AgentError: There is not one finite rank per actor.
    """
    check_ranks(ranks, ids)
    return np.sort(np.lexsort((ids, -ranks))[:most])


def check_ranks(ranks: np.ndarray, ids: np.ndarray) -> None:
    """Check that there is one finite rank per actor.

    Raises:
        AgentError: There is not.
    """
    if ranks.shape != ids.shape or not np.isfinite(ranks).all():
        message = f"rank: expected {ids.shape} finite values, got shape {ranks.shape}."
        raise AgentError(message)
