"""Which actors matter: rankings that need no learned planner (PlanT, section 4.3: baselines).

A ranker that declares `inputs` and has `reset` is treated as planners are; it is given what it
declares.
"""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import NO_ACTOR, Input, Observation
from plant_bench.agents.expert import Expert
from plant_bench.errors import AgentError
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, ActorKind, Actors, EgoState

TOUCHING = 0.01  # m, below which distances count alike


class Nearest:
    """Ranks by inverse distance between the centres of the boxes."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return 1/m for each actor.

        Raises:
            AgentError: The observation holds no actors.
        """
        distance = distances(observation.ego, actors_of(observation))
        return 1.0 / np.maximum(distance, TOUCHING)


class Random:
    """Ranks anew by chance at each decision; equal scenes get equal ranks."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return a number of 0 to 1 for each actor.

        Raises:
            AgentError: The observation holds no actors.
        """
        ids = actors_of(observation).ids.tolist()
        return np.random.default_rng([round(observation.time / TICK), *ids]).random(len(ids))


class Oracle:
    """Ranks first the vehicle that the expert would brake for if it saw all vehicles.

    All others follow, the nearer the higher; so who is nearest is first where it brakes for nobody.
    """

    inputs = Expert.inputs

    def __init__(self) -> None:
        self._expert = Expert()

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._expert.reset(route)

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return 1 for whom the expert brakes for, below 0 for the others.

        To be called once a decision, since the expert remembers how long it has waited.

        Raises:
            AgentError: The observation holds no actors.
        """
        actors = actors_of(observation)
        ranks = -distances(observation.ego, actors)
        self._expert.act(observation.showing(actors.kinds != ActorKind.PEDESTRIAN))
        who = self._expert.explain().actor
        if who != NO_ACTOR:
            ranks[actors.ids == who] = 1.0
        return ranks


def actors_of(observation: Observation) -> Actors:
    """Return the actors in sight.

    Raises:
        AgentError: The observation holds none.
    """
    if observation.actors is None:
        message = f"A ranking needs the input '{Input.OBJECTS}'."
        raise AgentError(message)
    return observation.actors


def distances(ego: EgoState, actors: Actors) -> Float[np.ndarray, " actors"]:
    """Return the distances between the centres of the boxes, metres."""
    poses = actors.poses.astype(float)
    return np.hypot(poses[:, 0] - ego.x, poses[:, 1] - ego.y)
