"""Chooses routes of given lengths from many random drafts, for variety and little overlap."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from plant_bench.errors import InputError
from plant_bench.towns.route_graph import END_MARGIN, START_AFTER, StreetGraph
from plant_bench.towns.route_lanes import LanePlan, plan_lanes
from plant_bench.towns.route_making import count_manoeuvres, make_route
from plant_bench.towns.route_paths import random_path
from plant_bench.world.route import Route

MAX_SHARE = 0.66  # largest overlap of two routes, as a share of the shorter one
SHORTEST = 0.93  # drafts shorter than this share of the longest draft are ignored
LENGTH_TOLERANCE = 0.03  # drafts shorter than the longest by up to this share are candidates
NOVELTY = 1.0  # score of a manoeuvre that the town's routes do not have yet
VARIETY = 0.25  # score of each kind of manoeuvre
BUSYNESS = 0.1  # score of one manoeuvre per kilometre, without lane changes
REVISITS = 0.5  # penalty for each repeated junction
OVERLAP = 3.0  # penalty for a full overlap with another route


@dataclass(frozen=True, eq=False)
class Draft:
    """A candidate route without its centre line.

    Attributes:
        plan: Its lanes.
        end: Arc length of its end on the last lane, metres. All drafts start `START_AFTER` metres
            after a junction.
        length: Approximate length, metres.
        driven: Distance driven on each edge, metres.
    """

    plan: LanePlan
    end: float
    length: float
    driven: Mapping[str, float]

    def make(self, graph: StreetGraph, name: str) -> Route:
        """Compute the route."""
        return make_route(graph, self.plan, name=name, start=START_AFTER, end=self.end)


class _Cut(NamedTuple):
    last: int
    end: float
    length: float


def draft_paths(graph: StreetGraph, count: int, rng: np.random.Generator) -> list[LanePlan]:
    """Draw random edge paths and plan their lanes; paths without a valid plan are dropped."""
    paths = (random_path(graph, rng) for _ in range(count))
    plans = (plan_lanes(graph, path) for path in paths if path is not None and len(path) > 1)
    return [plan for plan in plans if plan is not None]


def shorten(graph: StreetGraph, plan: LanePlan, longest: float) -> Draft | None:
    """Cut a plan to the longest draft of at most `longest` metres; None if nothing is left."""
    cut = _cut(graph, plan, longest)
    return None if cut is None else _draft(graph, plan, cut)


def _cut(graph: StreetGraph, plan: LanePlan, longest: float) -> _Cut | None:
    lanes, ends = graph.town.lanes, set(graph.ends)
    at, best = -START_AFTER, None
    for index, (edge, entered) in enumerate(zip(plan.edges, plan.entered, strict=True)):
        end = min(lanes[entered].length - END_MARGIN, longest - at)
        if longest - at < END_MARGIN:
            break
        if index > 0 and edge in ends and end >= END_MARGIN:
            best = _Cut(index, end, at + end)
        if index < len(plan.links):
            at += 0.5 * (lanes[entered].length + lanes[plan.left[index]].length)
            at += sum(lanes[via].length for via in plan.links[index].via)
    return best


def _draft(graph: StreetGraph, plan: LanePlan, cut: _Cut) -> Draft | None:
    replanned = plan_lanes(graph, plan.edges[: cut.last + 1])
    if replanned is None:
        return None
    end = min(cut.end, graph.town.lanes[replanned.left[-1]].length - END_MARGIN)
    driven = {edge: graph.lengths[edge] for edge in replanned.edges}
    driven[replanned.edges[0]] -= START_AFTER
    driven[replanned.edges[-1]] = end
    return Draft(replanned, end, cut.length, driven)


def overlap_share(one: Mapping[str, float], other: Mapping[str, float]) -> float:
    """Return the common distance of two routes as a share of the shorter route.

    Args:
        one: Distance driven on each edge by one route, metres.
        other: The same of the other route.
    """
    common = sum(min(metres, other.get(edge, 0.0)) for edge, metres in one.items())
    return common / min(sum(one.values()), sum(other.values()))


def distance_by_edge(route: Route) -> dict[str, float]:
    """Return the distance that a route drives on each edge outside junctions, metres."""
    driven: dict[str, float] = {}
    for span in route.lanes:
        if not span.lane.startswith(":"):
            edge = span.lane.rsplit("_", 1)[0]
            driven[edge] = driven.get(edge, 0.0) + span.end - span.start
    return driven


def choose(graph: StreetGraph, plans: list[LanePlan], limits: Sequence[float]) -> list[Draft]:
    """Choose a draft for each limit in turn: long, varied, and unlike those chosen before.

    Args:
        graph: The town's edges.
        plans: Lane plans to choose from.
        limits: Maximum lengths of the routes, metres.

    Raises:
        InputError: The plans do not give enough different drafts.
    """
    chosen: list[Draft] = []
    for limit in limits:
        drafts = _longest(graph, plans, limit)
        overlaps = [
            max((overlap_share(d.driven, c.driven) for c in chosen), default=0.0) for d in drafts
        ]
        pairs = [pair for pair in zip(drafts, overlaps, strict=True) if pair[1] <= MAX_SHARE]
        if not pairs:
            message = (
                f"Only {len(chosen)} different routes were found in {graph.town.name}, "
                f"{len(limits)} were requested. Request fewer, or use a larger town."
            )
            raise InputError(message)
        enough = (1.0 - LENGTH_TOLERANCE) * max(draft.length for draft, _ in pairs)
        seen = {kind for draft in chosen for kind in _kinds(graph, draft)}
        scores = [
            _score(graph, draft, overlap, seen) if draft.length >= enough else -np.inf
            for draft, overlap in pairs
        ]
        chosen.append(pairs[int(np.argmax(scores))][0])
    return chosen


def _longest(graph: StreetGraph, plans: list[LanePlan], limit: float) -> list[Draft]:
    """Return the drafts up to a length that are not much shorter than the longest one."""
    cuts = [(plan, cut) for plan in plans if (cut := _cut(graph, plan, limit)) is not None]
    enough = SHORTEST * max((cut.length for _, cut in cuts), default=0.0)
    drafts = (_draft(graph, plan, cut) for plan, cut in cuts if cut.length >= enough)
    return [draft for draft in drafts if draft is not None]


def _kinds(graph: StreetGraph, draft: Draft) -> set[str]:
    return {kind for kind, count in count_manoeuvres(graph, draft.plan).items() if count}


def _score(graph: StreetGraph, draft: Draft, overlap: float, seen: set[str]) -> float:
    counts = count_manoeuvres(graph, draft.plan)
    kinds = {kind for kind, count in counts.items() if count}
    busy = (sum(counts.values()) - counts["lane_change"]) / (draft.length / 1000.0)
    passed = [link.junction for link in draft.plan.links]
    again = len(passed) - len(set(passed))
    score = NOVELTY * len(kinds - seen) + VARIETY * len(kinds) + BUSYNESS * busy
    return round(score - REVISITS * again - OVERLAP * overlap, 6)
