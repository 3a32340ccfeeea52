"""A SUMO network as XML: what of it is asked about and changed between two conversions."""

from collections.abc import Collection, Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from plant_bench.geometry.polyline import arc_lengths, resample
from plant_bench.world.town import Link

LIFT = 6.0  # m
LIFT_TOP = 12.0  # m of road before and after the crossing that are at the full height
LIFT_RAMP = 60.0  # m of road over which it rises
LIFT_STEP = 3.0  # m between the points of a lifted edge
BEND_SPREAD = 6.0  # m: standard deviation of the blur that rounds bends
BEND_STEP = 1.5  # m between the points of a rounded edge

Way = tuple[str, str]  # the lanes that a connection leads from and to
Place = tuple[float, float]


def way_of(connection: Element) -> Way:
    """Return the lanes that a connection leads from and to."""
    values = connection.attrib
    return f"{values['from']}_{values['fromLane']}", f"{values['to']}_{values['toLane']}"


def way_of_link(link: Link) -> Way:
    """Return the same of a town's link."""
    return link.source, link.target


def without_ways(net: str, ways: Collection[Way]) -> str:
    """Return a network without some connections; netconvert takes the lanes inside junctions."""
    root = ElementTree.fromstring(net)
    for connection in root.findall("connection"):
        if way_of(connection) in ways:
            root.remove(connection)
    return ElementTree.tostring(root, encoding="unicode")


def drawn_ways(net: str) -> set[Way]:
    """Return the connections whose lines the map itself gives."""
    root = ElementTree.fromstring(net)
    return {way_of(item) for item in root.findall("connection") if item.get("shape")}


def without_lines(net: str, ways: Collection[Way]) -> str:
    """Return a network without the map's lines of some connections; netconvert draws its own."""
    root = ElementTree.fromstring(net)
    for connection in root.findall("connection"):
        if way_of(connection) in ways:
            connection.attrib.pop("shape", None)
    return ElementTree.tostring(root, encoding="unicode")


def turnarounds(net: str) -> list[Way]:
    """Return the connections that turn back on the spot."""
    root = ElementTree.fromstring(net)
    return [way_of(item) for item in root.findall("connection") if item.get("dir") == "t"]


def ends_of_edges(net: str) -> dict[str, tuple[str, str]]:
    """Return the junctions at the begin and the end of each edge outside junctions."""
    edges = ElementTree.fromstring(net).findall("edge")
    return {e.attrib["id"]: (e.attrib["from"], e.attrib["to"]) for e in edges if "from" in e.attrib}


def net_offset(net: str) -> tuple[float, float]:
    """Return what a map's coordinates were moved by to be the network's, x and y, metres."""
    location = ElementTree.fromstring(net).find("location")
    if location is None:
        return 0.0, 0.0
    x, y = location.get("netOffset", "0,0").split(",")
    return float(x), float(y)


def with_lifts(net: str, lifts: Mapping[str, Sequence[Place]]) -> str:
    """Return a network whose edges rise near some places; lanes follow when it is converted again.

    Args:
        net: XML text.
        lifts: For each edge to be lifted the places where it is to be at its highest.
    """
    root = ElementTree.fromstring(net)
    nodes = {node.attrib["id"]: node for node in root.findall("junction")}
    for edge in root.findall("edge"):
        if edge.attrib["id"] in lifts:
            _set_shape(edge, _lifted(_points(edge, nodes), lifts[edge.attrib["id"]]))
    return ElementTree.tostring(root, encoding="unicode")


def with_round_bends(net: str, edges: Collection[str]) -> str:
    """Return a network whose edges bend gently; lanes follow when it is converted again."""
    root = ElementTree.fromstring(net)
    nodes = {node.attrib["id"]: node for node in root.findall("junction")}
    for edge in root.findall("edge"):
        if edge.attrib["id"] in edges:
            _set_shape(edge, _rounded(_points(edge, nodes)))
    return ElementTree.tostring(root, encoding="unicode")


def _rounded(points: np.ndarray) -> np.ndarray:
    """The line blurred along itself, its ends kept."""
    fine = resample(points, BEND_STEP)
    reach = min(round(3.0 * BEND_SPREAD / BEND_STEP), len(fine) - 1)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) * BEND_STEP / BEND_SPREAD) ** 2)
    head = 2.0 * fine[0] - fine[reach:0:-1]
    tail = 2.0 * fine[-1] - fine[-2 : -reach - 2 : -1]
    padded = np.concatenate((head, fine, tail))
    columns = [np.convolve(c, weights / weights.sum(), mode="valid") for c in padded.T]
    return np.stack(columns, axis=1)


def _set_shape(edge: Element, points: np.ndarray) -> None:
    edge.set("shape", " ".join(",".join(f"{v:.2f}" for v in point) for point in points))


def _points(edge: Element, nodes: Mapping[str, Element]) -> np.ndarray:
    """The line that an edge's lanes lie beside, x, y, z."""
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
