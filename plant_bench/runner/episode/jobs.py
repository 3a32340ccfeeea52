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
        agent: Name of the agent, as for `load_agent`.
        agent_checksum: Content hash of the agent.
        route: Route to drive.
        repetition: Number of the repetition, from 0.
        seed: The scenario's seed.
        density: Traffic density.
        hazards: Whether the route's hazards are enabled.
        planner: Name of the agent with the paths of another machine; empty if `agent` is valid.
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
        """The scenario: everything that defines the episode except the agent."""
        return Scenario(self.route, self.seed, self.density, self.hazards)

    @cached_property
    def key(self) -> str:
        """Content hash of the scenario, the planner, the town and the rules."""
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
        """Return the part of the record that is known before the episode starts."""
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
    return int.from_bytes(digest[:4], "big") >> 1  # SUMO accepts 31 bits


def select_routes(routes: Sequence[Route], selection: str | None) -> list[Route]:
    """Return the routes of a selection such as "0,3-5,town02-1", in the suite's order.

    Args:
        routes: The suite.
        selection: Indices of routes from 0, ranges of indices and route ids; None for all.

    Raises:
        InputError: A part names no route.
    """
    chosen = set(select_ids([route.id for route in routes], selection))
    return [route for route in routes if route.id in chosen]


def select_ids(ids: Sequence[str], selection: str | None) -> list[str]:
    """Return the route ids of a selection; see `select_routes`.

    Raises:
        InputError: A part names no route.
    """
    if selection is None:
        return list(ids)
    chosen: set[int] = set()
    for part in selection.split(","):
        chosen.update(_indices(list(ids), part.strip()))
    return [name for index, name in enumerate(ids) if index in chosen]


def _indices(ids: list[str], part: str) -> range:
    if part in ids:
        return range(ids.index(part), ids.index(part) + 1)
    first, dash, last = part.partition("-")
    if first.isdecimal() and (last.isdecimal() or not dash):
        indices = range(int(first), int(last or first) + 1)
        if indices and indices[-1] < len(ids):
            return indices
    message = (
        f"There is no route '{part}' in this suite: expected numbers from 0 to {len(ids) - 1}, "
        f"ranges such as 0-2, or ids such as {ids[0]}.{did_you_mean(part, ids)}"
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
        agent: Name of the agent, as for `load_agent`.
        agent_checksum: Content hash of the agent.
        routes: Routes to drive.
        repetitions: Episodes per route, each with its own seed.
        seed: The base seed.
        density: Traffic density.
        hazards: Whether the routes' hazards are enabled.
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
    """Return the name of an episode's files: route, repetition and key."""
    route = re.sub(r"[^\w.-]", "_", job.route.id)
    return f"{route}_r{job.repetition}_{job.key[:KEY_LENGTH]}"
