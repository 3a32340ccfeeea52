"""A street plan: nodes, one-way edges and lane connections, as input for netconvert."""

from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from plant_bench.errors import InputError
from plant_bench.towns.street_shapes import Shape


@dataclass(frozen=True)
class Node:
    """A junction, or a point where one edge continues as another.

    `control` is a SUMO junction type; `radius` is that of the junction's corners, in metres;
    `crossings` allows pedestrian crossings; `fixed_time` signals are never actuated.
    """

    id: str
    x: float
    y: float
    control: str = "priority"
    radius: float = 8.0
    z: float = 0.0
    crossings: bool = True
    fixed_time: bool = False


@dataclass(frozen=True)
class Edge:
    """A one-way carriageway with `lanes` lanes for vehicles.

    `shape` (n 2 or n 3) is its left border, or its middle line if `centred`.
    """

    id: str
    start: str
    end: str
    lanes: int
    speed: float
    shape: Shape
    road_class: str
    priority: int = 3
    centred: bool = False
    sidewalk: bool = False


@dataclass(frozen=True)
class Connection:
    """A connection from one lane to another; vehicle lanes are counted from the right, from 0."""

    start: str
    end: str
    start_lane: int
    end_lane: int


@dataclass
class StreetPlan:
    """All nodes, edges and connections of a town, the input of netconvert; mutable."""

    nodes: dict[str, Node] = field(default_factory=dict)
    edges: dict[str, Edge] = field(default_factory=dict)
    connections: list[Connection] = field(default_factory=list)

    def add_node(self, node: Node) -> Node:
        """Add a node; its name must be new."""
        if node.id in self.nodes:
            raise InputError(
                f"Node {node.id} occurs twice in a street plan: expected unique names."
            )
        self.nodes[node.id] = node
        return node

    def add_edge(self, edge: Edge) -> Edge:
        """Add an edge; its name must be new and its nodes known."""
        if edge.id in self.edges or not {edge.start, edge.end} <= self.nodes.keys():
            raise InputError(f"Edge {edge.id} occurs twice or lacks a node in a street plan.")
        self.edges[edge.id] = edge
        return edge

    def connect(self, start: str, end: str, pairs: list[tuple[int, int]]) -> None:
        """Connect lanes of one edge to lanes of another, as pairs (from, to)."""
        self.connections += [Connection(start, end, a, b) for a, b in pairs]

    def arriving(self, node: str) -> list[Edge]:
        """Return the edges that end at a node."""
        return [edge for edge in self.edges.values() if edge.end == node]

    def leaving(self, node: str) -> list[Edge]:
        """Return the edges that begin at a node."""
        return [edge for edge in self.edges.values() if edge.start == node]

    def write(self, folder: Path) -> None:
        """Write `plan.nod.xml`, `plan.edg.xml` and `plan.con.xml`."""
        _write(folder / "plan.nod.xml", "nodes", [_node_xml(n) for n in self.nodes.values()])
        _write(folder / "plan.edg.xml", "edges", [_edge_xml(e) for e in self.edges.values()])
        connections = [self._connection_xml(c) for c in self.connections]
        connections += [
            ElementTree.Element("crossing", {"node": node.id, "discard": "true"})
            for node in self.nodes.values()
            if not node.crossings
        ]
        _write(folder / "plan.con.xml", "connections", connections)

    def _connection_xml(self, connection: Connection) -> ElementTree.Element:
        # A sidewalk is lane 0 of its edge, so vehicle lanes start at 1 there.
        start, end = self.edges[connection.start], self.edges[connection.end]
        values = {
            "from": start.id,
            "to": end.id,
            "fromLane": str(connection.start_lane + start.sidewalk),
            "toLane": str(connection.end_lane + end.sidewalk),
        }
        return ElementTree.Element("connection", values)


def _node_xml(node: Node) -> ElementTree.Element:
    values = {
        "id": node.id,
        "x": f"{node.x:.3f}",
        "y": f"{node.y:.3f}",
        "z": f"{node.z:.3f}",
        "type": node.control,
        "radius": f"{node.radius:g}",
    }
    if node.fixed_time:
        values["tlType"] = "static"
    return ElementTree.Element("node", values)


def _edge_xml(edge: Edge) -> ElementTree.Element:
    values = {
        "id": edge.id,
        "from": edge.start,
        "to": edge.end,
        "type": edge.road_class,
        "numLanes": str(edge.lanes),
        "speed": f"{edge.speed:.2f}",
        "priority": str(edge.priority),
        "spreadType": "center" if edge.centred else "right",
        "shape": " ".join(",".join(f"{v:.3f}" for v in point) for point in np.asarray(edge.shape)),
    }
    if edge.sidewalk:
        values["sidewalkWidth"] = "2.00"
    else:
        values["allow"] = "passenger"
    return ElementTree.Element("edge", values)


def _write(path: Path, tag: str, children: list[ElementTree.Element]) -> None:
    root = ElementTree.Element(tag)
    root.extend(children)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
