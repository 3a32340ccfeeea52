"""Builds training routes, long ones and short ones by manoeuvre, distinct from the benchmark's.

A training route may use streets of benchmark routes in the same town. Its overlap with any one of
them is at most `MAX_COMMON` of the shorter of the two, so no training route is, contains or is part
of a benchmark route. Traffic, hazards and seeds differ everywhere.
"""

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from plant_bench.geometry.polyline import headings
from plant_bench.towns.route_choice import Draft, distance_by_edge, overlap_share, shorten
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_hazards import METRES_EACH, place_hazards
from plant_bench.towns.route_lanes import plan_lanes
from plant_bench.towns.route_making import count_manoeuvres
from plant_bench.towns.route_paths import random_path
from plant_bench.towns.routes import SUITES
from plant_bench.world.hazard import Hazard
from plant_bench.world.route import Route, load_suite, suite_names
from plant_bench.world.town import Town

MAX_COMMON = 0.5  # largest overlap with a benchmark route, as a share of the shorter one
LONG = "long"
SHORT_KINDS = (
    "left_signal",
    "left",
    "right_signal",
    "right",
    "straight_signal",
    "straight",
    "curve",
    "lane_change",
    "roundabout",
    "merge",
    "exit",
)
SHORT_LENGTH = (100.0, 400.0)  # m
LONG_PER_VISIT = 2  # long routes per visit of a town
MARGIN = 0.02  # safety margin of the overlap: a draft's length differs slightly from its route's
TRIES = 1500  # random paths for all long routes, and for all short routes
BEND = 0.6  # rad: smallest change of heading of a curve


def training_visits(town: Town, base: str, visits: int, seed: int) -> list[list[Route]]:
    """Return a town's training routes, grouped by the visit on which they are driven.

    Each visit has `LONG_PER_VISIT` long routes and one short route of each kind, in random order;
    fewer if the town does not have enough different routes.

    Args:
        town: The town.
        base: The benchmark's town whose route lengths the long routes follow.
        visits: Number of visits.
        seed: Seed of routes and hazards.
    """
    graph = StreetGraph(town)
    rng = np.random.default_rng([seed, *town.name.encode()])
    forbidden = [distance_by_edge(route) for route in benchmark_routes() if route.town == town.name]
    longs = _long_drafts(graph, rng, SUITES["longest6"].lengths[base], visits, forbidden)
    shorts = _short_drafts(graph, rng, visits, forbidden)
    found = []
    for visit in range(visits):
        chosen = [(LONG, i) for i in range(visit * LONG_PER_VISIT, (visit + 1) * LONG_PER_VISIT)]
        chosen += [(kind, visit) for kind in SHORT_KINDS]
        drafts = {LONG: longs} | shorts
        present = [(kind, i) for kind, i in chosen if i < len(drafts[kind])]
        order = rng.permutation(len(present)).tolist()
        picked = [present[place] for place in order]
        found.append([_make(graph, drafts[kind][i], kind, i, seed) for kind, i in picked])
    return found


@cache
def benchmark_routes() -> tuple[Route, ...]:
    """Return the routes of all suites in `routes/`."""
    return tuple(route for name in suite_names() for route in load_suite(name))


def kinds_of(graph: StreetGraph, draft: Draft) -> set[str]:
    """Return the kinds of short route to which a draft belongs."""
    plan = draft.plan
    counts = count_manoeuvres(graph, plan)
    kinds = {kind for kind in ("lane_change", "roundabout", "merge", "exit") if counts[kind]}
    for link, edge, onward in zip(plan.links, plan.edges, plan.edges[1:], strict=False):
        if graph.is_crossing(link.junction) and not graph.is_exit(edge, onward):
            kinds.add(f"{link.turn}_signal" if link.signal is not None else link.turn)
    if any(_is_curve(graph, edge) for edge in plan.edges):
        kinds.add("curve")
    return kinds


def _is_curve(graph: StreetGraph, edge: str) -> bool:
    if edge in graph.ring_edges or edge in graph.u_turns:
        return False
    points = graph.town.edges[edge][0].points[:, :2]
    steps = np.hypot(*np.diff(points, axis=0).T) > 0.05
    yaw = headings(points[np.concatenate(([True], steps))])
    return abs(float(yaw[-1] - yaw[0])) > BEND


def _is_distinct(draft: Draft, forbidden: Sequence[Mapping[str, float]]) -> bool:
    return all(overlap_share(draft.driven, other) <= MAX_COMMON - MARGIN for other in forbidden)


def _long_drafts(
    graph: StreetGraph,
    rng: np.random.Generator,
    lengths: Sequence[float],
    visits: int,
    forbidden: Sequence[Mapping[str, float]],
) -> list[Draft]:
    """Draw different drafts with lengths in the range of the benchmark's routes."""
    target, found, known = visits * LONG_PER_VISIT, [], set()
    for _ in range(TRIES):
        path = random_path(graph, rng)
        longest = float(rng.uniform(min(lengths), max(lengths)))
        plan = None if path is None or len(path) < 2 else plan_lanes(graph, path)
        draft = None if plan is None else shorten(graph, plan, longest)
        if draft is None or draft.length < 0.75 * longest or draft.plan.edges in known:
            continue
        if _is_distinct(draft, forbidden):
            found.append(draft)
            known.add(draft.plan.edges)
        if len(found) == target:
            break
    return found


def _short_drafts(
    graph: StreetGraph,
    rng: np.random.Generator,
    visits: int,
    forbidden: Sequence[Mapping[str, float]],
) -> dict[str, list[Draft]]:
    """Draw different drafts of each kind; a draft of several kinds goes to the rarest."""
    found: dict[str, list[Draft]] = {kind: [] for kind in SHORT_KINDS}
    known: set[tuple[str, ...]] = set()
    for draft in _pieces(graph, rng):
        if draft.plan.edges in known:
            continue
        kinds = [kind for kind in kinds_of(graph, draft) if len(found[kind]) < visits]
        if kinds and _is_distinct(draft, forbidden):
            least = min(kinds, key=lambda kind: (len(found[kind]), -SHORT_KINDS.index(kind)))
            found[least].append(draft)
            known.add(draft.plan.edges)
        if all(len(drafts) == visits for drafts in found.values()):
            break
    return found


def _pieces(graph: StreetGraph, rng: np.random.Generator) -> Iterator[Draft]:
    """Cut random paths into short drafts, from every edge on which a route may start."""
    starts = set(graph.starts)
    for _ in range(TRIES):
        path = random_path(graph, rng) or ()
        for first in range(len(path) - 1):
            if path[first] not in starts:
                continue
            longest = float(rng.uniform(*SHORT_LENGTH))
            plan = plan_lanes(graph, _path_prefix(graph, path[first:], longest))
            draft = None if plan is None else shorten(graph, plan, longest)
            if draft is not None and draft.length >= SHORT_LENGTH[0]:
                yield draft


def _path_prefix(graph: StreetGraph, path: tuple[str, ...], longest: float) -> tuple[str, ...]:
    """Return the first edges of a path within reach of a draft of a length, at least two."""
    so_far = 0.0
    for count, edge in enumerate(path, start=1):
        so_far += graph.lengths[edge]
        if so_far > longest + graph.lengths[path[0]] and count > 1:
            return path[:count]
    return path


def _make(graph: StreetGraph, draft: Draft, kind: str, number: int, seed: int) -> Route:
    route = draft.make(graph, f"{graph.town.name}-{kind}-{number}")
    hazards = place_hazards(graph.town, route, seed)
    return replace(
        route, hazards=hazards if kind == LONG else _sample_hazards(hazards, route, seed)
    )


def _sample_hazards(hazards: tuple[Hazard, ...], route: Route, seed: int) -> tuple[Hazard, ...]:
    """Sample the hazards of a short route to the density of long routes."""
    target = max(round(route.length / METRES_EACH), 1)
    if len(hazards) <= target:
        return hazards
    kept = random.Random(f"{seed}|{route.id}|fewer").sample(range(len(hazards)), target)
    return tuple(hazards[place] for place in sorted(kept))
