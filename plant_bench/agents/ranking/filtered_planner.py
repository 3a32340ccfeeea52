"""A planner that is shown only the actors that rank highest (PlanT, section 4.3: RFDS)."""

import numpy as np

from plant_bench.agent import Agent, Control, Explains, Input, Observation, Plan, Ranker, Reason
from plant_bench.agent_check import decision_interval
from plant_bench.errors import AgentError
from plant_bench.sensing.inputs import restrict
from plant_bench.world.route import Route
from plant_bench.world.scene import ActorKind, Actors


class Filtered:
    """Drives as another planner would that sees only who matters most to a ranker.

    The ego, the route and the light stay in view. A ranker that has inputs and can be reset, as a
    planner, is reset with the route and given those inputs, of all actors; no action of it is asked
    for.

    Args:
        agent: Who drives.
        ranker: Who tells which actors matter.
        most: How many of them are shown.
        vehicles_only: Filter vehicles alone; pedestrians stay in view, as for PlanT's RFDS.

    Raises:
        AgentError: The agent takes no objects, or `most` is negative.
    """

    def __init__(
        self, agent: Agent, ranker: Ranker, most: int = 1, *, vehicles_only: bool = False
    ) -> None:
        if Input.OBJECTS not in agent.inputs or most < 0:
            message = (
                f"Filtered({type(agent).__name__}, most={most}): a planner with the input "
                "'objects' is wanted, and a number of actors from 0."
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
        """Rank all actors, and let the planner decide with the first of them."""
        seen = restrict(observation, self._agent.inputs)
        if seen.actors is None:
            message = "A filtered planner needs the input 'objects'."
            raise AgentError(message)
        ranks = self._ranker.rank(restrict(observation, self._ranker_inputs))
        return self._agent.act(seen.showing(self._shown(ranks, seen.actors)))

    def explain(self) -> Reason | None:
        """Return the planner's reason, if it tells."""
        return self._agent.explain() if isinstance(self._agent, Explains) else None

    def _shown(self, ranks: np.ndarray, actors: Actors) -> np.ndarray:
        """Return the places of the actors that are shown, in their order."""
        if not self._vehicles_only:
            return highest(ranks, actors.ids, self._most)
        check_ranks(ranks, actors.ids)
        shown = actors.kinds == ActorKind.PEDESTRIAN
        places = np.flatnonzero(~shown)
        shown[places[highest(ranks[places], actors.ids[places], self._most)]] = True
        return np.flatnonzero(shown)


def inputs_of(ranker: Ranker) -> frozenset[str]:
    """Return what a ranker must be given to rank: what it declares, or else the objects."""
    return getattr(ranker, "inputs", frozenset({Input.OBJECTS}))


def highest(ranks: np.ndarray, ids: np.ndarray, most: int) -> np.ndarray:
    """Return the places of the actors that rank highest, in their order; ties go to lower ids.

    Args:
        ranks: One for each actor.
        ids: Of the actors.
        most: How many are wanted.

    Raises:
        AgentError: There is not one finite rank for each actor.
    """
    check_ranks(ranks, ids)
    return np.sort(np.lexsort((ids, -ranks))[:most])


def check_ranks(ranks: np.ndarray, ids: np.ndarray) -> None:
    """Check that there is one finite rank for each actor.

    Raises:
        AgentError: There is not.
    """
    if ranks.shape != ids.shape or not np.isfinite(ranks).all():
        message = f"rank returned shape {ranks.shape}: {ids.shape} finite values are wanted."
        raise AgentError(message)
