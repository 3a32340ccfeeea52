"""Chooses routes with hazards through an imported town, like those of the benchmark."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plant_bench.errors import InputError
from plant_bench.towns.route_choice import Draft, choose, draft_paths
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_hazards import place_hazards
from plant_bench.world.route import Route
from plant_bench.world.town import Town

DRAWS = 1500  # random edge paths to choose from
MAX_ROUTES = 200


@dataclass(frozen=True)
class RouteRequest:
    """Settings for choosing routes.

    Attributes:
        count: Number of routes.
        shortest: Minimum length, metres.
        longest: Maximum length, metres.
        seed: Seed of routes and hazards.
        hazards: Whether hazards are placed on the routes.
    """

    count: int = 6
    shortest: float = 400.0
    longest: float = 1500.0
    seed: int = 0
    hazards: bool = True

    def check(self) -> None:
        """Check the numbers.

        Raises:
            InputError: One is out of range.
        """
        if not 1 <= self.count <= MAX_ROUTES:
            raise InputError(f"--routes: expected 1 to {MAX_ROUTES}, got {self.count}.")
        if not 100.0 <= self.shortest <= self.longest <= 50_000.0:
            raise InputError(
                f"--min-length and --max-length: expected 100 <= min <= max <= 50000, got "
                f"{self.shortest:g} and {self.longest:g}."
            )


def make_routes(town: Town, request: RouteRequest) -> list[Route]:
    """Return different routes through a town, longest first; fewer if it has fewer.

    Raises:
        InputError: The town has no route of the requested length.
    """
    rng = np.random.default_rng([request.seed, zlib.crc32(town.name.encode())])
    graph = StreetGraph(town)
    plans = draft_paths(graph, DRAWS, rng) if graph.starts and graph.ends else []
    limits = np.linspace(request.longest, request.shortest, request.count + 1)[: request.count]
    drafts: list[Draft] = []
    for count in range(request.count, 0, -1):
        try:
            drafts = choose(graph, plans, limits[:count].tolist())
        except InputError:
            continue
        break
    routes = [draft.make(graph, f"{town.name}-{i}") for i, draft in enumerate(drafts)]
    routes = [route for route in routes if route.length >= request.shortest]
    if not routes:
        longest = max((draft.length for draft in drafts), default=0.0)
        raise InputError(
            f"The town has no route of {request.shortest:.0f} m or more; the longest found has "
            f"{longest:.0f} m. Lower --min-length, or use a larger map."
        )
    return with_hazards(town, routes, request.seed) if request.hazards else routes


def with_hazards(town: Town, routes: Sequence[Route], seed: int) -> list[Route]:
    """Return the routes with hazards placed on them."""
    return [replace(route, hazards=place_hazards(town, route, seed)) for route in routes]
