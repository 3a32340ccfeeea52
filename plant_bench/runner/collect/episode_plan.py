"""Which episodes data is collected on: an endless order, of which as many are driven as it takes.

The order depends on the request alone. Towns are visited in turn, each time on other routes; when
all routes have been driven, they are driven again in other traffic, as PlanT's 2x and 3x data.
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

VISITS = 5  # of a town before its routes are driven again; all routes are about one unit
EXPERT = "expert"
RESERVED_SEEDS, RESERVED_REPETITIONS = 20, 20  # base seeds and repetitions of the benchmark


@dataclass(frozen=True)
class PlannedEpisode:
    """One episode to be driven; picklable.

    Attributes:
        job: What to drive.
        perturbed: Whether with perturbations.
        driver: Who drives while the job's agent answers; empty if it drives itself.
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
    """Yield episodes without end, in the order in which they count.

    Args:
        request: What is asked for.
        towns: In the order they are visited.
        visits: Gives a town's routes, grouped by visit; asked for when they are needed.
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
    return PlannedEpisode(job, _share_of(seed) < request.perturb, request.driver)


def training_seed(seed: int, route: str, repetition: int) -> int:
    """Return an episode's traffic seed: never one that the benchmark drives with.

    >>> training_seed(0, "town01-long-0", 0) in benchmark_seeds()
    False
    """
    attempt = 0
    while True:
        found = repetition_seed(seed, f"training|{attempt}|{route}", repetition)
        if found not in benchmark_seeds():
            return found
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


def _share_of(seed: int) -> float:
    """Return a number of 0 to 1 that a seed decides."""
    digest = hashlib.sha256(f"perturbed|{seed}".encode()).digest()
    return int.from_bytes(digest[:4], "big") / 2.0**32
