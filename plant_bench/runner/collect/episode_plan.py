"""Plans the episodes of data collection, as an endless sequence.

The sequence depends on the request alone. Towns are visited in turn, on other routes at each visit.
When all routes have been driven, they are driven again in other traffic, as for PlanT's 2x and 3x
data.
"""

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import count

from plant_bench.runner.collect.request import CollectRequest
from plant_bench.runner.episode.jobs import Job, episode_name, repetition_seed
from plant_bench.towns.training_routes import benchmark_routes
from plant_bench.towns.training_towns import TrainingTown
from plant_bench.world.route import Route

VISITS = 5  # visits of a town before its routes repeat; all routes together are about one UNIT
EXPERT = "expert"
RESERVED_SEEDS, RESERVED_REPETITIONS = 20, 20  # base seeds and repetitions of the benchmark


@dataclass(frozen=True)
class PlannedEpisode:
    """One episode to drive; picklable.

    Attributes:
        job: The job, whose agent's actions are recorded.
        perturbed: Whether the executed control is perturbed.
        driver: The planner whose actions are executed; empty if it is the job's agent.
    """

    job: Job
    perturbed: bool
    driver: str = ""

    @property
    def name(self) -> str:
        """The name of its files."""
        return episode_name(self.job)


def planned_episodes(
    request: CollectRequest,
    towns: list[TrainingTown],
    visits: Callable[[TrainingTown], list[list[Route]]],
    agent_checksum: str,
) -> Iterator[PlannedEpisode]:
    """Yield episodes without end, in the order in which they are added to the data.

    Args:
        request: The request.
        towns: Towns in the order of visits.
        visits: Returns a town's routes, grouped by visit; called when they are needed.
        agent_checksum: Content hash of the expert.
    """
    for repetition in count():
        for visit in range(VISITS):
            for town in towns:
                for route in visits(town)[visit]:
                    yield _planned(request, route, repetition, agent_checksum)


def _planned(
    request: CollectRequest, route: Route, repetition: int, agent_checksum: str
) -> PlannedEpisode:
    seed = training_seed(request.seed, route.id, repetition)
    job = Job(
        agent=EXPERT,
        agent_checksum=agent_checksum,
        route=route,
        repetition=repetition,
        seed=seed,
        density=request.density,
    )
    return PlannedEpisode(job, _uniform_of(seed) < request.perturb, request.driver)


def training_seed(seed: int, route: str, repetition: int) -> int:
    """Return an episode's traffic seed, which is never one of the benchmark's.

    >>> training_seed(0, "town01-long-0", 0) in benchmark_seeds()
    False
    """
    attempt = 0
    while True:
        candidate = repetition_seed(seed, f"training|{attempt}|{route}", repetition)
        if candidate not in benchmark_seeds():
            return candidate
        attempt += 1


@cache
def benchmark_seeds() -> frozenset[int]:
    """Return the traffic seeds of the benchmark's first base seeds and repetitions."""
    return frozenset(
        repetition_seed(seed, route.id, repetition)
        for seed in range(RESERVED_SEEDS)
        for route in benchmark_routes()
        for repetition in range(RESERVED_REPETITIONS)
    )


def _uniform_of(seed: int) -> float:
    """Return a pseudo-random number from 0 to 1 for a seed."""
    digest = hashlib.sha256(f"perturbed|{seed}".encode()).digest()
    return int.from_bytes(digest[:4], "big") / 2.0**32
