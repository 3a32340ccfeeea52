"""Baseline rankers: nearest, random, and the expert's choice (PlanT, section 4.3).

A ranker with `inputs` and `reset` is handled like a planner and gets the inputs that it declares.
"""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import NO_ACTOR, Input, Observation
from plant_bench.agents.expert import Expert
from plant_bench.errors import AgentError
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK, ActorKind, Actors, EgoState

MIN_DISTANCE = 0.01  # m, below which distances are treated as equal


class Nearest:
    """Ranks by inverse distance between the centres of the boxes."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return 1/m for each actor.

        Raises:
            AgentError: The observation has no actors.
        """
        distance = distances(observation.ego, actors_of(observation))
        return 1.0 / np.maximum(distance, MIN_DISTANCE)


class Random:
    """Random ranks at each decision, seeded by time and ids: equal scenes get equal ranks."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return a number from 0 to 1 for each actor.

        Raises:
            AgentError: The observation has no actors.
        """
        ids = actors_of(observation).ids.tolist()
        return np.random.default_rng([round(observation.time / TICK), *ids]).random(len(ids))


class Oracle:
    """Ranks first the vehicle that the expert would brake for if it saw all vehicles.

    The others follow by distance; if the expert brakes for no vehicle, the nearest is first.
    """

    inputs = Expert.inputs

    def __init__(self) -> None:
        self._expert = Expert()

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._expert.reset(route)

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return 1 for the vehicle that the expert brakes for, below 0 for the others.

        Must be called once per decision, since the expert's state includes its waiting time.

        Raises:
            AgentError: The observation has no actors.
        """
        actors = actors_of(observation)
        ranks = -distances(observation.ego, actors)
        self._expert.act(observation.showing(actors.kinds != ActorKind.PEDESTRIAN))
        actor = self._expert.explain().actor
        if actor != NO_ACTOR:
            ranks[actors.ids == actor] = 1.0
        return ranks


def actors_of(observation: Observation) -> Actors:
    """Return the actors in sight.

    Raises:
        AgentError: The observation has none.
    """
    if observation.actors is None:
        message = f"A ranker needs the input '{Input.OBJECTS}'."
        raise AgentError(message)
    return observation.actors


def distances(ego: EgoState, actors: Actors) -> Float[np.ndarray, " actors"]:
    """Return the distances between the centres of the boxes, metres."""
    poses = actors.poses.astype(float)
    return np.hypot(poses[:, 0] - ego.x, poses[:, 1] - ego.y)
