"""Benchmark-like routes through an imported town: as many as it has, with hazards."""

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

DRAWS = 1500  # edge paths drawn
MOST_ROUTES = 200


@dataclass(frozen=True)
class RouteRequest:
    """What routes are asked for.

    Attributes:
        count: How many.
        shortest: Metres.
        longest: Metres.
        seed: Of the drawing.
        hazards: Whether hazards are placed on them.
    """

    count: int = 6
    shortest: float = 400.0
    longest: float = 1500.0
    seed: int = 0
    hazards: bool = True

    def check(self) -> None:
        """Check that the numbers go together.

        Raises:
            InputError: They do not.
        """
        if not 1 <= self.count <= MOST_ROUTES:
            raise InputError(f"--routes {self.count} found, 1 to {MOST_ROUTES} wanted.")
        if not 100.0 <= self.shortest <= self.longest <= 50_000.0:
            raise InputError(
                f"Routes of {self.shortest:g} to {self.longest:g} m are asked for: --min-length of "
                "100 or more, and --max-length no less than it and up to 50000 are wanted."
            )


def make_routes(town: Town, wanted: RouteRequest) -> list[Route]:
    """Return different routes through a town, the longest first; fewer where it has fewer.

    Raises:
        InputError: The town has no route of such a length.
    """
    rng = np.random.default_rng([wanted.seed, zlib.crc32(town.name.encode())])
    graph = StreetGraph(town)
    plans = draft_paths(graph, DRAWS, rng) if graph.starts and graph.ends else []
    limits = np.linspace(wanted.longest, wanted.shortest, wanted.count + 1)[: wanted.count]
    drafts: list[Draft] = []
    for count in range(wanted.count, 0, -1):
        try:
            drafts = choose(graph, plans, limits[:count].tolist())
        except InputError:
            continue
        break
    routes = [draft.make(graph, f"{town.name}-{i}") for i, draft in enumerate(drafts)]
    routes = [route for route in routes if route.length >= wanted.shortest]
    if not routes:
        longest = max((draft.length for draft in drafts), default=0.0)
        raise InputError(
            f"The town has no route of {wanted.shortest:.0f} m or more; the longest found has "
            f"{longest:.0f} m. Lower --min-length, or take a larger map."
        )
    return with_hazards(town, routes, wanted.seed) if wanted.hazards else routes


def with_hazards(town: Town, routes: Sequence[Route], seed: int) -> list[Route]:
    """Return routes with hazards placed on them."""
    return [replace(route, hazards=place_hazards(town, route, seed)) for route in routes]
