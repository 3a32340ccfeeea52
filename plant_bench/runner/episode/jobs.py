"""Jobs: the episodes of a run, from selected routes and repetitions, each with its seed."""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from plant_bench.errors import InputError, did_you_mean
from plant_bench.runner.episode.keys import rules_checksum
from plant_bench.scoring.results import EpisodeHeader
from plant_bench.world.route import Route, Scenario

KEY_LENGTH = 8  # characters of a job's key in the name of its files


@dataclass(frozen=True)
class Job:
    """One episode to be driven; picklable.

    Attributes:
        agent: As given to `load_agent`.
        agent_checksum: Content hash of the agent.
        route: To drive.
        repetition: From 0.
        seed: The scenario's seed.
        density: Of the traffic.
        hazards: Whether the route's hazards are played.
        planner: The agent's name where it is driven, if it lies elsewhere there; empty if not.
    """

    agent: str
    agent_checksum: str
    route: Route
    repetition: int
    seed: int
    density: str
    hazards: bool = True
    planner: str = ""

    @cached_property
    def scenario(self) -> Scenario:
        """What the episode depends on, apart from the agent."""
        return Scenario(self.route, self.seed, self.density, self.hazards)

    @cached_property
    def key(self) -> str:
        """A content hash: of the scenario, the planner, the town and the rules as they are."""
        parts = (
            self.scenario.protocol,
            self.agent,
            self.agent_checksum,
            self.scenario.key,
            str(self.repetition),
            self.route.town_checksum,
            rules_checksum(),
        )
        return hashlib.sha256("|".join(parts).encode()).hexdigest()

    def header(self, inputs: frozenset[str]) -> EpisodeHeader:
        """Return what is known before the episode starts."""
        return EpisodeHeader(
            protocol=self.scenario.protocol,
            agent=self.agent,
            agent_checksum=self.agent_checksum,
            inputs=tuple(sorted(inputs)),
            route=self.route.id,
            town=self.route.town,
            scenario=self.scenario.key,
            repetition=self.repetition,
            seed=self.seed,
            density=self.density,
            town_checksum=self.route.town_checksum,
            route_checksum=self.route.checksum,
        )


def repetition_seed(seed: int, route: str, repetition: int) -> int:
    """Return an episode's seed: the same for every agent, so that runs can be paired.

    >>> repetition_seed(0, "town01-0", 0) == repetition_seed(0, "town01-0", 0)
    True
    >>> repetition_seed(0, "town01-0", 0) == repetition_seed(0, "town01-0", 1)
    False
    """
    digest = hashlib.sha256(f"{seed}|{route}|{repetition}".encode()).digest()
    return int.from_bytes(digest[:4], "big") >> 1  # SUMO takes 31 bits


def select_routes(routes: Sequence[Route], selection: str | None) -> list[Route]:
    """Return the routes that a text like "0,3-5,town02-1" names, in the suite's order.

    Args:
        routes: The suite.
        selection: Places in the suite counted from 0, ranges of them, and route ids; None is all.

    Raises:
        InputError: A part names no route.
    """
    chosen = set(select_ids([route.id for route in routes], selection))
    return [route for route in routes if route.id in chosen]


def select_ids(ids: Sequence[str], selection: str | None) -> list[str]:
    """Return the route ids that a selection names; as `select_routes`.

    Raises:
        InputError: A part names no route.
    """
    if selection is None:
        return list(ids)
    chosen: set[int] = set()
    for part in selection.split(","):
        chosen.update(_places(list(ids), part.strip()))
    return [name for place, name in enumerate(ids) if place in chosen]


def _places(ids: list[str], part: str) -> range:
    if part in ids:
        return range(ids.index(part), ids.index(part) + 1)
    first, dash, last = part.partition("-")
    if first.isdecimal() and (last.isdecimal() or not dash):
        places = range(int(first), int(last or first) + 1)
        if places and places[-1] < len(ids):
            return places
    message = (
        f"There is no route '{part}' in this suite: numbers 0 to {len(ids) - 1}, ranges such as "
        f"0-2 and ids such as {ids[0]} are wanted.{did_you_mean(part, ids)}"
    )
    raise InputError(message)


def make_jobs(
    agent: str,
    agent_checksum: str,
    routes: Sequence[Route],
    *,
    repetitions: int,
    seed: int,
    density: str,
    hazards: bool = True,
) -> list[Job]:
    """Return one job for each route and repetition.

    Args:
        agent: As given to `load_agent`.
        agent_checksum: Content hash of the agent.
        routes: To drive.
        repetitions: Episodes on each route, each with a seed of its own.
        seed: The base seed.
        density: Of the traffic.
        hazards: Whether the routes' hazards are played.
    """
    return [
        Job(
            agent=agent,
            agent_checksum=agent_checksum,
            route=route,
            repetition=repetition,
            seed=repetition_seed(seed, route.id, repetition),
            density=density,
            hazards=hazards,
        )
        for route in routes
        for repetition in range(repetitions)
    ]


def episode_name(job: Job) -> str:
    """Return the name of an episode's files, which tells all that the episode depends on."""
    route = re.sub(r"[^\w.-]", "_", job.route.id)
    return f"{route}_r{job.repetition}_{job.key[:KEY_LENGTH]}"
