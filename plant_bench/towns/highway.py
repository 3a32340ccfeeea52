"""Lays out a closed highway whose carriageways gain and lose lanes at ramps and U-turns.

Positions along a carriageway are arc lengths of its reference line (the middle of the median), in
its own direction of travel, in metres.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from plant_bench.towns.street_plan import Edge, Node, StreetPlan
from plant_bench.towns.street_shapes import (
    Pose,
    Shape,
    arc_lengths,
    corner,
    end_pose,
    join,
    offset,
    thin_out,
    tightest_radius,
)
from plant_bench.towns.town_spec import RoadClass

Leads = Literal["out", "in"]

LATERAL_ACCELERATION = 3.0
NODE_RADIUS_M = 2.0
DIVERGE_M = 70.0
DIVERGE_BY_M = 10.0
DIVERGE_POWER = 1.6
RAMP_CORNER_M = 45.0


@dataclass(frozen=True)
class Branch:
    """An extra lane beside a carriageway, and the one-way edge (ramp or U-turn) that it serves.

    The extra lane lies before an exit (`leads` = "out") or after an entry (`leads` = "in"), on the
    right for a ramp, on the left for a U-turn over the median. The edge connects at position `at`.
    """

    edge: str
    at: float
    side: Literal["right", "left"]
    leads: Leads
    lane_length: float

    def covers(self, place: float, total: float) -> bool:
        """Return whether the extra lane exists at a position of a carriageway of a total length."""
        begin = self.at - self.lane_length if self.leads == "out" else self.at
        return (place - begin) % total < self.lane_length


@dataclass
class Carriageway:
    """One direction of a closed highway.

    `line` (n 3) is the closed reference line in the direction of travel, with equal first and last
    points; `inset` is the distance from it to the carriageway's left border, in metres.
    """

    name: str
    line: Shape
    inset: float
    road: RoadClass
    lane_width: float
    branches: list[Branch] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Compute the arc lengths of the reference line."""
        self._along = arc_lengths(self.line)

    @property
    def total(self) -> float:
        """Length of the reference line, metres."""
        return float(self._along[-1])

    def nearest(self, x: float, y: float) -> float:
        """Return the position on the reference line nearest to a point."""
        return float(self._along[np.hypot(self.line[:, 0] - x, self.line[:, 1] - y).argmin()])

    def cut(self, begin: float, end: float, left: float | Shape = 0.0, step: float = 1.0) -> Shape:
        """Return a line (n 3) along the carriageway, `left` metres left of its left border.

        `left` is one value, or one per point.
        """
        length = (end - begin) % self.total
        even = max(2, int(np.ceil(length / step)) + 1)
        count = len(left) if isinstance(left, np.ndarray) else even
        places = (begin + np.linspace(-step, length + step, count + 2)) % self.total
        places[1:-1] = (begin + np.linspace(0.0, length, count)) % self.total
        line = np.stack([np.interp(places, self._along, column) for column in self.line.T], axis=1)
        inset = np.pad(np.broadcast_to(left, (count,)), 1, mode="edge") - self.inset
        return offset(line, inset)[1:-1]

    def lane_middle(self, lane: int) -> float:
        """Return the offset of a lane's middle from the left border, positive to the left.

        Lane 0 is the rightmost; lane -1 is the extra lane of a ramp.
        """
        return -(self.road.lanes - lane - 0.5) * self.lane_width

    def node_at(self, edge: str) -> str:
        """Return the name of the node where a branch's edge meets the carriageway."""
        return f"{self.name}_{edge}"

    def add_to(self, plan: StreetPlan) -> None:
        """Add the carriageway's nodes and edges; the branches' own edges come later."""
        stops = self._stops()
        for place, name in stops:
            x, y, z = self.cut(place, place + 2.0)[0]
            plan.add_node(Node(name, x, y, "priority", NODE_RADIUS_M, float(z), crossings=False))
        for (begin, start), (finish, end) in zip(stops, stops[1:] + stops[:1], strict=True):
            lefts, rights = self._extras(begin)
            shape = self.cut(begin, finish, lefts * self.lane_width)
            bend = tightest_radius(shape, window=20.0)
            speed = min(self.road.speed, float(np.sqrt(LATERAL_ACCELERATION * bend)))
            lanes = self.road.lanes + lefts + rights
            plan.add_edge(Edge(start, start, end, lanes, speed, thin_out(shape), "highway", 12))

    def connect(self, plan: StreetPlan) -> None:
        """Connect the carriageway's edges with each other and with the branches' edges."""
        stops = self._stops()
        for (begin, start), (finish, end) in zip(stops, stops[1:] + stops[:1], strict=True):
            before, after = self._extras(begin), self._extras(finish)
            right = 1 if before[1] and after[1] and not self._ends_at(finish, "right") else 0
            left = 1 if before[0] and after[0] and not self._ends_at(finish, "left") else 0
            lanes = range(-right, self.road.lanes + left)
            plan.connect(start, end, [(k + before[1], k + after[1]) for k in lanes])
        before_stop = {b: a for (_, a), (_, b) in zip(stops, stops[1:] + stops[:1], strict=True)}
        for branch in self.branches:
            node = self.node_at(branch.edge)
            carrier = before_stop[node] if branch.leads == "out" else node
            lane = 0 if branch.side == "right" else plan.edges[carrier].lanes - 1
            if branch.leads == "out":
                plan.connect(carrier, branch.edge, [(lane, 0)])
            else:
                plan.connect(branch.edge, carrier, [(0, lane)])

    def _ends_at(self, place: float, side: str) -> bool:
        """Return whether no extra lane of a side continues through a position."""
        reach = [b for b in self.branches if b.side == side and b.covers(place + 0.01, self.total)]
        return not any(b.covers(place - 0.01, self.total) for b in reach)

    def _extras(self, place: float) -> tuple[int, int]:
        """Return the numbers of extra lanes on the left and on the right, just after a position."""
        inside = [b.side for b in self.branches if b.covers(place + 0.01, self.total)]
        return inside.count("left"), inside.count("right")

    def _stops(self) -> list[tuple[float, str]]:
        """Return all positions where the number of lanes changes, with the names of their nodes."""
        stops = []
        for branch in self.branches:
            out = branch.leads == "out"
            far = branch.at - branch.lane_length if out else branch.at + branch.lane_length
            stops.append((branch.at % self.total, self.node_at(branch.edge)))
            stops.append(
                (far % self.total, self.node_at(branch.edge) + ("_begin" if out else "_end"))
            )
        return sorted(stops)


def exit_shape(way: Carriageway, at: float, goal: Pose, goal_z: float = 0.0) -> Shape:
    """Return the middle line (n 3) of a ramp that leaves a carriageway and ends in a pose."""
    growth = DIVERGE_BY_M * np.linspace(0, 1, int(DIVERGE_M) + 1) ** DIVERGE_POWER
    away = way.cut(at, at + DIVERGE_M, way.lane_middle(-1) - growth)
    rest = corner(end_pose(away), goal, RAMP_CORNER_M)
    return _with_height([away, rest], float(away[0, 2]), goal_z)


def entry_shape(way: Carriageway, at: float, source: Pose, source_z: float = 0.0) -> Shape:
    """Return the middle line (n 3) of a ramp that begins in a pose and joins a carriageway."""
    growth = DIVERGE_BY_M * np.linspace(1, 0, int(DIVERGE_M) + 1) ** DIVERGE_POWER
    near = way.cut(at - DIVERGE_M, at, way.lane_middle(-1) - growth)
    first = Pose(*_xy(near[0]), _heading(near))
    rest = corner(source, first, RAMP_CORNER_M)
    return _with_height([rest, near], source_z, float(near[-1, 2]))


def service_shape(way: Carriageway, begin: float, end: float, away: float) -> Shape:
    """Return the middle line (n 3) of a service road: it leaves, runs `away` metres beside, joins.

    `begin` and `end` are its positions on the carriageway.
    """
    count = int(np.ceil((end - begin) % way.total)) + 1
    along = np.linspace(0.0, (end - begin) % way.total, count)
    from_end = np.minimum(along, along[::-1]) / (1.2 * DIVERGE_M)
    rise = np.clip(from_end, 0.0, 1.0)
    return way.cut(begin, end, way.lane_middle(-1) - away * rise**2 * (3 - 2 * rise))


def u_turn_shape(start: Pose, end: Pose, straight: float) -> Shape:
    """Return a U-turn from one pose to another: straight, a half circle to the left, straight."""
    angles = np.linspace(0.0, np.pi, 25)
    first, last = start.ahead(straight), end.ahead(-straight)
    middle = (first.point + last.point) / 2
    spoke = first.point - middle
    turned = np.stack(
        [
            spoke[0] * np.cos(angles) - spoke[1] * np.sin(angles),
            spoke[0] * np.sin(angles) + spoke[1] * np.cos(angles),
        ],
        axis=1,
    )
    return join([start.point[None], middle + turned, end.point[None]])


def _with_height(pieces: list[Shape], begin: float, end: float) -> Shape:
    line = join([piece[:, :2] for piece in pieces])
    along = arc_lengths(line)
    rise = np.clip((along / along[-1] - 0.08) / 0.84, 0.0, 1.0)
    height = begin + (end - begin) * rise**2 * (3 - 2 * rise)
    return np.column_stack([line, height])


def _xy(point: Shape) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _heading(line: Shape) -> float:
    return float(np.arctan2(line[1, 1] - line[0, 1], line[1, 0] - line[0, 0]))


def two_carriageways(
    line: Shape, median: float, road: RoadClass, lane_width: float
) -> tuple[Carriageway, Carriageway]:
    """Return the carriageways in and against the direction of a closed line in their middle."""
    half = median / 2
    outer = Carriageway("outer", line, half, road, lane_width)
    inner = Carriageway("inner", line[::-1].copy(), half, road, lane_width)
    return outer, inner
