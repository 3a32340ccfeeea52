"""Queries and edits of a SUMO network as XML, applied between two conversions."""

from collections.abc import Collection, Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import arc_lengths, resample
from plant_bench.world.town import Link

LIFT = 6.0  # m that an edge is raised by
LIFT_TOP = 12.0  # m of road before and after the crossing at full height
LIFT_RAMP = 60.0  # m of road over which it rises
LIFT_STEP = 3.0  # m between the points of a raised edge
BEND_STEP = 1.5  # m between the points of a rounded edge

LanePair = tuple[str, str]  # source and target lane of a connection
Place = tuple[float, float]


def lane_pair(connection: Element) -> LanePair:
    """Return the source and target lane of a connection."""
    values = connection.attrib
    return f"{values['from']}_{values['fromLane']}", f"{values['to']}_{values['toLane']}"


def lane_pair_of_link(link: Link) -> LanePair:
    """Return the source and target lane of a town's link."""
    return link.source, link.target


def without_connections(net: str, pairs: Collection[LanePair]) -> str:
    """Return a network without the connections in `pairs`; netconvert removes their lanes."""
    root = ElementTree.fromstring(net)
    for connection in root.findall("connection"):
        if lane_pair(connection) in pairs:
            root.remove(connection)
    return ElementTree.tostring(root, encoding="unicode")


def connections_with_shape(net: str) -> set[LanePair]:
    """Return the connections with a shape in the map itself."""
    root = ElementTree.fromstring(net)
    return {lane_pair(item) for item in root.findall("connection") if item.get("shape")}


def without_shapes(net: str, pairs: Collection[LanePair]) -> str:
    """Return a network without the shapes of some connections; netconvert computes new ones."""
    root = ElementTree.fromstring(net)
    for connection in root.findall("connection"):
        if lane_pair(connection) in pairs:
            connection.attrib.pop("shape", None)
    return ElementTree.tostring(root, encoding="unicode")


def turnarounds(net: str) -> list[LanePair]:
    """Return the connections that are U-turns within a junction (SUMO's direction "t")."""
    root = ElementTree.fromstring(net)
    return [lane_pair(item) for item in root.findall("connection") if item.get("dir") == "t"]


def ends_of_edges(net: str) -> dict[str, tuple[str, str]]:
    """Return the junctions at the start and end of each edge outside junctions."""
    edges = ElementTree.fromstring(net).findall("edge")
    return {e.attrib["id"]: (e.attrib["from"], e.attrib["to"]) for e in edges if "from" in e.attrib}


def net_offset(net: str) -> tuple[float, float]:
    """Return the offset from a map's coordinates to the network's, x and y, metres."""
    location = ElementTree.fromstring(net).find("location")
    if location is None:
        return 0.0, 0.0
    x, y = location.get("netOffset", "0,0").split(",")
    return float(x), float(y)


def with_junction_shapes(net: str, shapes: Mapping[str, Float[np.ndarray, "points 2"]]) -> str:
    """Return a network whose junctions have given outlines; roads are cut off at them.

    Args:
        net: XML text.
        shapes: The outline of each junction to change, x, y.
    """
    root = ElementTree.fromstring(net)
    for node in root.findall("junction"):
        points = shapes.get(node.attrib["id"])
        if points is not None:
            node.set("customShape", "true")
            node.set("shape", " ".join(f"{x:.2f},{y:.2f}" for x, y in points.tolist()))
    return ElementTree.tostring(root, encoding="unicode")


def with_fixed_junctions(net: str, junctions: Collection[str]) -> str:
    """Return a network whose junctions keep their present outlines when it is converted again."""
    root = ElementTree.fromstring(net)
    for node in root.findall("junction"):
        if node.attrib["id"] in junctions and len(node.get("shape", "").split()) > 2:
            node.set("customShape", "true")
    return ElementTree.tostring(root, encoding="unicode")


def with_net_offset_moved(net: str, by: Place) -> str:
    """Return a network whose recorded offset to the map's coordinates is changed.

    netconvert takes the header's offset of an OpenDRIVE map for a shift of its coordinates.
    """
    if by == (0.0, 0.0):
        return net
    root = ElementTree.fromstring(net)
    location = root.find("location")
    if location is not None:
        x, y = net_offset(net)
        location.set("netOffset", f"{x + by[0]:.2f},{y + by[1]:.2f}")
    return ElementTree.tostring(root, encoding="unicode")


def with_lifts(net: str, lifts: Mapping[str, Sequence[Place]]) -> str:
    """Return a network with raised edges; its lanes follow when it is converted again.

    Args:
        net: XML text.
        lifts: For each edge to raise, the positions where it is highest.
    """
    root = ElementTree.fromstring(net)
    nodes = {node.attrib["id"]: node for node in root.findall("junction")}
    for edge in root.findall("edge"):
        if edge.attrib["id"] in lifts:
            _set_shape(edge, _lifted(_points(edge, nodes), lifts[edge.attrib["id"]]))
    return ElementTree.tostring(root, encoding="unicode")


def with_round_bends(net: str, spreads: Mapping[str, float]) -> str:
    """Return a network with smoothed edges; its lanes follow when it is converted again.

    Args:
        net: XML text.
        spreads: The standard deviation of the blur for each edge, metres.
    """
    root = ElementTree.fromstring(net)
    nodes = {node.attrib["id"]: node for node in root.findall("junction")}
    for edge in root.findall("edge"):
        if edge.attrib["id"] in spreads:
            _set_shape(edge, _rounded(_points(edge, nodes), spreads[edge.attrib["id"]]))
    return ElementTree.tostring(root, encoding="unicode")


def _rounded(points: np.ndarray, spread: float) -> np.ndarray:
    """Return a line smoothed by a Gaussian, with its ends kept."""
    fine = resample(points, BEND_STEP)
    reach = min(round(3.0 * spread / BEND_STEP), len(fine) - 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) * BEND_STEP / spread) ** 2)
    head = 2.0 * fine[0] - fine[reach:0:-1]
    tail = 2.0 * fine[-1] - fine[-2 : -reach - 2 : -1]
    padded = np.concatenate((head, fine, tail))
    columns = [np.convolve(c, weights / weights.sum(), mode="valid") for c in padded.T]
    return np.stack(columns, axis=1)


def _set_shape(edge: Element, points: np.ndarray) -> None:
    edge.set("shape", " ".join(",".join(f"{v:.2f}" for v in point) for point in points))


def _points(edge: Element, nodes: Mapping[str, Element]) -> np.ndarray:
    """Return an edge's reference line, x, y, z."""
    shape = edge.get("shape")
    if shape is None:
        ends = (nodes[edge.attrib[end]] for end in ("from", "to"))
        return np.array([[float(node.get(axis, "0")) for axis in "xyz"] for node in ends])
    points = [[float(value) for value in point.split(",")] for point in shape.split()]
    return np.array([[*point, 0.0][:3] for point in points])


def _lifted(points: np.ndarray, places: Sequence[Place]) -> np.ndarray:
    fine = resample(points, LIFT_STEP)
    along, rise = arc_lengths(fine[:, :2]), np.zeros(len(fine))
    for x, y in places:
        centre = along[np.argmin(np.hypot(fine[:, 0] - x, fine[:, 1] - y))]
        away = np.clip((np.abs(along - centre) - LIFT_TOP) / LIFT_RAMP, 0.0, 1.0)
        rise = np.maximum(rise, 0.5 * LIFT * (1.0 + np.cos(np.pi * away)))
    fine[:, 2] += rise
    return fine
