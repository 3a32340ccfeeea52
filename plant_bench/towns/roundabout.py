"""Lays out a two-lane roundabout: a ring, and an entry and an exit for each arm."""

from dataclasses import dataclass

import numpy as np

from plant_bench.towns.street_plan import Edge, Node, StreetPlan
from plant_bench.towns.street_shapes import Pose, Shape, curve_between
from plant_bench.towns.town_spec import TownSpec

LANES = 2
SPEED = 8.33
PRIORITY = 10
HALF_GAP = float(np.radians(21))  # between an arm and its entry or exit, on the ring
APPROACH = float(np.radians(27))  # between an entry or exit and the arm's direction
ARM_LENGTH_M = 34.0
NODE_RADIUS_M = 6.0


@dataclass(frozen=True)
class Roundabout:
    """Position and size of a roundabout; `arms` maps names of street ends to angles, radians."""

    name: str
    centre: tuple[float, float]
    radius: float
    arms: dict[str, float]

    def mouth(self, arm: str) -> Pose:
        """Return the pose where an arm's two-way street begins, facing outwards."""
        return Pose(*self.centre, self.arms[arm]).ahead(self.radius + ARM_LENGTH_M)

    def on_ring(self, angle: float) -> Pose:
        """Return the pose on the ring's middle line at an angle, in the direction of travel."""
        x, y = Pose(*self.centre, angle).ahead(self.radius).point
        return Pose(float(x), float(y), angle + np.pi / 2)


def add_roundabout(plan: StreetPlan, spec: TownSpec, ring: Roundabout) -> None:
    """Add a ring with its entries and exits, and connect it with the arms' streets.

    The nodes and streets of the arms must be in the plan already.
    """
    stops: list[tuple[float, str]] = []
    for arm, angle in ring.arms.items():
        for kind, side in (("out", -HALF_GAP), ("in", HALF_GAP)):
            stops.append(((angle + side) % (2 * np.pi), f"{ring.name}_{kind}_{arm}"))
    stops.sort()
    for angle, name in stops:
        pose = ring.on_ring(angle)
        plan.add_node(Node(name, pose.x, pose.y, "priority", NODE_RADIUS_M))
    arcs = {}
    for (begin, start), (finish, end) in zip(stops, stops[1:] + stops[:1], strict=True):
        shape = _arc(ring, begin, begin + (finish - begin) % (2 * np.pi))
        arc = Edge(
            f"{start}-{end}", start, end, LANES, SPEED, shape, "ring", PRIORITY, centred=True
        )
        arcs[start] = plan.add_edge(arc)
    for arm in ring.arms:
        _add_arm(plan, spec, ring, arm)
    for arc in arcs.values():
        plan.connect(arc.id, arcs[arc.end].id, [(0, 0), (1, 1)])
        for edge in plan.leaving(arc.end):
            if edge.id != arcs[arc.end].id:
                plan.connect(arc.id, edge.id, [(0, 0)])
    for arm in ring.arms:
        entry = plan.edges[f"{arm}-{ring.name}_in_{arm}"]
        plan.connect(entry.id, arcs[entry.end].id, [(k, k) for k in range(entry.lanes)])


def _arc(ring: Roundabout, begin: float, finish: float) -> Shape:
    count = max(4, int(np.ceil((finish - begin) * ring.radius / 1.5)))
    angles = np.linspace(begin, finish, count + 1)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.array(ring.centre) + ring.radius * circle


def _add_arm(plan: StreetPlan, spec: TownSpec, ring: Roundabout, arm: str) -> None:
    angle, mouth = ring.arms[arm], ring.mouth(arm)
    inward = next(edge for edge in plan.arriving(arm))
    outward = next(edge for edge in plan.leaving(arm))
    width = spec.lane_width
    goal = ring.on_ring(angle + HALF_GAP)
    entry = curve_between(
        mouth.reversed().beside(-width * inward.lanes / 2),
        Pose(goal.x, goal.y, angle + np.pi - APPROACH),
    )
    source = ring.on_ring(angle - HALF_GAP)
    leave = curve_between(Pose(source.x, source.y, angle + APPROACH), mouth.beside(-width / 2))
    ends = (f"{ring.name}_in_{arm}", f"{ring.name}_out_{arm}")
    for start, end, lanes, shape in (
        (arm, ends[0], inward.lanes, entry),
        (ends[1], arm, 1, leave),
    ):
        name = f"{start}-{end}"
        plan.add_edge(Edge(name, start, end, lanes, inward.speed, shape, "ring", 3, centred=True))
    plan.connect(inward.id, f"{arm}-{ends[0]}", [(k, k) for k in range(inward.lanes)])
    plan.connect(f"{ends[1]}-{arm}", outward.id, [(0, k) for k in range(outward.lanes)])
