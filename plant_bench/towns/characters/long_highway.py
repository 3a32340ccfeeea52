"""Lays out two long highways joined to a ring, with ramps, U-turns and service roads.

The outer carriageway runs counter-clockwise, the inner one clockwise. Ramps connect the inner one
with the road inside the ring; U-turns over the median connect the two carriageways.
"""

import numpy as np

from plant_bench.towns.highway import (
    Branch,
    Carriageway,
    Leads,
    entry_shape,
    exit_shape,
    service_shape,
    two_carriageways,
    u_turn_shape,
)
from plant_bench.towns.street_map import EAST, NORTH, SOUTH, WEST, add_street
from plant_bench.towns.street_plan import Edge, Node, StreetPlan
from plant_bench.towns.street_shapes import (
    Pose,
    Shape,
    curve_through,
    end_pose,
    fillet,
    resample,
    thin_out,
)
from plant_bench.towns.town_spec import LongHighwayLayout, TownSpec
from plant_bench.towns.turns import connect_junction

RAMP_REACH_M = 135.0
SERVICE_LENGTH_M = 280.0
SERVICE_AWAY_M = 16.0
POCKET_M = 90.0
U_TURN_STRAIGHT_M = 14.0
LOOP_DEPTH_M = 105.0


def lay_out_long_highway(spec: TownSpec, rng: np.random.Generator) -> StreetPlan:
    """Lay out a ring of two long highways with a road between them."""
    layout = spec.layout
    if not isinstance(layout, LongHighwayLayout):
        raise TypeError(f"Long highways need a LongHighwayLayout, found {type(layout).__name__}.")
    return _Site(spec, layout, rng).plan_all()


class _Site:
    """Builds the street plan; mutable."""

    def __init__(self, spec: TownSpec, layout: LongHighwayLayout, rng: np.random.Generator) -> None:
        self.spec, self.layout, self.rng = spec, layout, rng
        self.width, self.height = spec.extent
        highway = spec.road("highway")
        self.margin = layout.median / 2 + (highway.lanes + 0.5) * spec.lane_width
        ways = two_carriageways(self._ring(), layout.median, highway, spec.lane_width)
        self.outer, self.inner = ways
        self.plan = StreetPlan()
        self.ramps: list[Edge] = []

    def plan_all(self) -> StreetPlan:
        """Return the complete street plan."""
        west, east = self._road_nodes()
        pairs = (("w", west, WEST), ("n", west, NORTH), ("e", east, EAST), ("s", east, SOUTH))
        for tag, node, side in pairs[: self.layout.ramp_pairs]:
            self._ramp_pair(tag, node, side)
        self._u_turns()
        self._services()
        for way in (self.outer, self.inner):
            way.add_to(self.plan)
        self._streets(west, east)
        for ramp in self.ramps:
            self.plan.add_edge(ramp)
        for way in (self.outer, self.inner):
            way.connect(self.plan)
        for name in ("west", "middle", "east"):
            connect_junction(self.plan, name)
        return self.plan

    def _ring(self) -> Shape:
        low, right, top = self.margin, self.width - self.margin, self.height - self.margin
        middle = self.width / 2
        corners = [(middle, low), (right, low), (right, top), (low, top), (low, low), (middle, low)]
        line = resample(fillet(corners, self.layout.bend_radius), 1.0)
        return np.column_stack([line, np.zeros(len(line))])

    def _jitter(self) -> float:
        return float(self.rng.uniform(-1, 1)) * self.layout.jitter

    def _road_nodes(self) -> tuple[Node, Node]:
        y = self.height / 2 + self._jitter() / 2
        west = Node("west", 0.36 * self.width + self._jitter(), y, "traffic_light", 10.0)
        east = Node("east", 0.64 * self.width + self._jitter(), y, "traffic_light", 10.0)
        return west, east

    def _ramp_pair(self, tag: str, node: Node, side: float) -> None:
        """Add a ramp from the inner carriageway to a junction's arm, and one back."""
        ramp, width = self.spec.road("ramp"), self.spec.lane_width
        arm = Pose(node.x, node.y, side).ahead(4.0)
        reach = RAMP_REACH_M
        foot = self._foot(arm)
        off, on = foot - reach, foot + reach + self._jitter() / 2
        into = arm.reversed().beside(-width / 2)
        out = arm.beside(-width / 2)
        start, end = exit_shape(self.inner, off, into), entry_shape(self.inner, on, out)
        spots: tuple[tuple[str, float, Leads], ...] = (
            (f"off_{tag}", off, "out"),
            (f"on_{tag}", on, "in"),
        )
        for name, at, leads in spots:
            self.inner.branches.append(Branch(name, at, "right", leads, self.layout.ramp_lane))
        off_node, on_node = (self.inner.node_at(f"{kind}_{tag}") for kind in ("off", "on"))
        self._add_ramp(f"off_{tag}", off_node, node.id, start, ramp.speed)
        self._add_ramp(f"on_{tag}", node.id, on_node, end, ramp.speed)

    def _foot(self, arm: Pose) -> float:
        """Return the position on the inner carriageway straight ahead of a junction's arm."""
        ahead = [arm.ahead(float(d)).point for d in range(20, int(self.width), 2)]
        nearest = min(ahead, key=lambda p: self._distance(float(p[0]), float(p[1])))
        return self.inner.nearest(float(nearest[0]), float(nearest[1]))

    def _distance(self, x: float, y: float) -> float:
        line = self.inner.line
        return float(np.hypot(line[:, 0] - x, line[:, 1] - y).min())

    def _add_ramp(self, name: str, start: str, end: str, shape: Shape, speed: float) -> None:
        self.ramps.append(
            Edge(name, start, end, 1, speed, thin_out(shape), "ramp", 3, centred=True)
        )

    def _u_turns(self) -> None:
        """Add U-turns in both directions over the median, on the long straights."""
        south, north = self.margin, self.height - self.margin
        spots = (
            (self.outer, self.inner, 0.33, south),
            (self.inner, self.outer, 0.64, south),
            (self.outer, self.inner, 0.67, north),
            (self.inner, self.outer, 0.36, north),
        )
        for number, (way, other, share, y) in enumerate(spots[: self.layout.u_turns]):
            x = share * self.width + self._jitter()
            leave, join_at = way.nearest(x, y), other.nearest(x, y)
            name = f"turn{number}"
            start = self._pocket_pose(way, leave)
            end = self._pocket_pose(other, join_at)
            way.branches.append(Branch(name, leave, "left", "out", POCKET_M))
            other.branches.append(Branch(name, join_at, "left", "in", POCKET_M))
            nodes = way.node_at(name), other.node_at(name)
            shape = u_turn_shape(start, end, U_TURN_STRAIGHT_M)
            self._add_ramp(name, *nodes, shape, self.spec.road("turn").speed)

    def _pocket_pose(self, way: Carriageway, at: float) -> Pose:
        return end_pose(way.cut(at - 2.0, at, 0.5 * self.spec.lane_width)[:, :2])

    def _services(self) -> None:
        """Add service roads that leave the outer carriageway and join it again."""
        spots = ((0.62, self.margin), (0.38, self.height - self.margin))
        for number, (share, y) in enumerate(spots[: self.layout.services]):
            middle = self.outer.nearest(share * self.width + self._jitter(), y)
            begin, end = middle - SERVICE_LENGTH_M / 2, middle + SERVICE_LENGTH_M / 2
            name, length = f"service{number}", self.layout.ramp_lane
            shape = service_shape(self.outer, begin, end, SERVICE_AWAY_M)
            self.outer.branches.append(Branch(name, begin, "right", "out", length))
            again = Branch(name + "_on", end, "right", "in", length)
            self.outer.branches.append(again)
            middle_node = f"{name}_middle"
            half = len(shape) // 2
            x, y_middle = shape[half, :2]
            self.plan.add_node(Node(middle_node, x, y_middle, radius=2.0, crossings=False))
            speed = self.spec.road("ramp").speed
            start, finish = self.outer.node_at(name), self.outer.node_at(name + "_on")
            self._add_ramp(name, start, middle_node, shape[: half + 1], speed)
            self._add_ramp(name + "_on", middle_node, finish, shape[half:], speed)
            self.plan.connect(name, name + "_on", [(0, 0)])

    def _streets(self, west: Node, east: Node) -> None:
        """Add the road between the highways, and two loops of streets beside it."""
        middle_x = (west.x + east.x) / 2 + self._jitter()
        middle = Node("middle", middle_x, west.y, "traffic_light", 8.0)
        for node in (west, middle, east):
            self.plan.add_node(node)
        for start, end in ((west, middle), (middle, east)):
            line = curve_through([Pose(start.x, start.y, EAST), Pose(end.x, end.y, EAST)])
            add_street(self.plan, self.spec, start.id, end.id, line, "avenue")
        radius = 30.0
        for node, depth in ((west, -LOOP_DEPTH_M), (east, LOOP_DEPTH_M)):
            low = node.y + depth + self._jitter() / 2
            corners = [(node.x, node.y), (node.x, low), (middle.x, low), (middle.x, middle.y)]
            line = fillet(corners, radius)
            add_street(self.plan, self.spec, node.id, "middle", line, "street")
