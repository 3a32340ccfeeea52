"""Entry points and random routes for each kind of vehicle in a town."""

import random
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from plant_bench.sim.long_vehicles import fits
from plant_bench.sim.vehicle_types import VEHICLE_TYPES
from plant_bench.world.scene import ActorKind
from plant_bench.world.town import Lane, Link, Town

SAMPLE_SPACING = 10.0  # m between entry points
ROUTE_AHEAD = 500.0  # m of random route per extension
STRAIGHT_WEIGHT = 3.0  # weight of going straight, relative to one turn
BICYCLE_LIMIT = 13.9  # m/s: bicycles keep to roads of at most 50 km/h
SIZES = {kind.kind: (kind.length, kind.width) for kind in VEHICLE_TYPES}  # the largest of a kind


@dataclass(frozen=True)
class _KindNetwork:
    """Network of one kind: allowed links by lane, and next edges with weights by edge."""

    links: dict[str, list[Link]]
    onward: dict[str, tuple[list[str], list[float]]]


class StreetGrid:
    """Entry points and random routes of a town; immutable.

    Every route can be continued without end on links that its kind may use.

    Args:
        town: The town.

    Attributes:
        town: The town.
        lanes: Lanes with entry points.
        lane_of: Index of each entry point's lane.
        share: Position of each entry point as a share of its lane's length.
        x: x of each entry point, metres.
        y: y of each entry point, metres.
    """

    def __init__(self, town: Town) -> None:
        self.town = town
        self.lanes: list[Lane] = []
        self.lane_of: list[int] = []
        self.share: list[float] = []
        xs: list[float] = []
        ys: list[float] = []
        for lane in town.lanes.values():
            if lane.junction is not None or lane.acceleration or lane.length < 2 * SAMPLE_SPACING:
                continue
            if lane.id not in town.links_from:
                continue
            self.lanes.append(lane)
            at = np.arange(SAMPLE_SPACING, lane.length - SAMPLE_SPACING, SAMPLE_SPACING)
            xs += np.interp(at, lane.along, lane.points[:, 0]).tolist()
            ys += np.interp(at, lane.along, lane.points[:, 1]).tolist()
            self.share += (at / lane.length).tolist()
            self.lane_of += [len(self.lanes) - 1] * len(at)
        self.x, self.y = np.array(xs), np.array(ys)
        self._ways = {kind: _ways(town, kind) for kind in SIZES}
        self._open = {kind: self._places(kind) for kind in SIZES}

    def open_to(self, kind: ActorKind) -> Bool[np.ndarray, " places"]:
        """Return a mask of the entry points that a kind of vehicle may use."""
        return self._open[kind]

    def walk(self, edge: str, kind: ActorKind, draw: random.Random) -> list[str]:
        """Return a random route of at least `ROUTE_AHEAD` metres that begins after an edge."""
        edges: list[str] = []
        length = 0.0
        while length < ROUTE_AHEAD:
            # A hazard may have sent a vehicle where its kind is not allowed: use a car's network.
            onward = self._ways[kind].onward.get(edge) or self._ways[ActorKind.CAR].onward[edge]
            edge = draw.choices(*onward)[0]
            edges.append(edge)
            length += self.town.edges[edge][0].length
        return edges

    def walk_from(self, lane: Lane, kind: ActorKind, draw: random.Random) -> tuple[str, ...]:
        """Return a random route that starts on a lane and leaves it without a lane change."""
        link = draw.choice(self._ways[kind].links[lane.id])
        first = self.town.lanes[link.target].edge
        return (lane.edge, first, *self.walk(first, kind, draw))

    def _places(self, kind: ActorKind) -> Bool[np.ndarray, " places"]:
        links = self._ways[kind].links
        lanes = np.array([lane.id in links for lane in self.lanes], bool)
        return lanes[np.array(self.lane_of, np.intp)]


def _ways(town: Town, kind: ActorKind) -> _KindNetwork:
    """Return the network of a kind of vehicle in a town."""
    edge_of = {lane.id: lane.edge for lane in town.lanes.values()}
    barred = {
        (edge_of[link.source], edge_of[link.target])
        for link in town.links
        if not _may_take(town, link, kind)
    }
    steps = {(edge_of[link.source], edge_of[link.target]) for link in town.links} - barred
    steps = _without_dead_ends(steps)
    links: dict[str, list[Link]] = {}
    weights: dict[str, dict[str, float]] = {}
    straight = (
        1.0 if kind is ActorKind.BICYCLE else STRAIGHT_WEIGHT
    )  # because cars queue behind bicycles
    for link in town.links:
        source, target = edge_of[link.source], edge_of[link.target]
        if (source, target) in steps:
            links.setdefault(link.source, []).append(link)
            onward = weights.setdefault(source, {})
            weight = straight if link.turn == "straight" else 1.0
            onward[target] = max(onward.get(target, 0.0), weight)
    return _KindNetwork(
        links, {edge: (list(to), list(to.values())) for edge, to in weights.items()}
    )


def _may_take(town: Town, link: Link, kind: ActorKind) -> bool:
    if kind is ActorKind.BICYCLE:
        edges = (town.lanes[link.source].edge, town.lanes[link.target].edge)
        return all(lane.speed_limit <= BICYCLE_LIMIT for edge in edges for lane in town.edges[edge])
    return fits(town, link, *SIZES[kind])


def _without_dead_ends(steps: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """Remove steps that lead to or come from dead ends."""
    while True:
        sources, targets = {step[0] for step in steps}, {step[1] for step in steps}
        kept = {step for step in steps if step[1] in sources and step[0] in targets}
        if kept == steps:
            return kept
        steps = kept
