"""A SUMO network as XML: what of it is asked about and changed between two conversions."""

from collections.abc import Callable, Collection, Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from plant_bench.geometry.polyline import arc_lengths, resample
from plant_bench.world.town import Link

LIFT = 6.0  # m
LIFT_TOP = 12.0  # m of road before and after the crossing that are at the full height
LIFT_RAMP = 60.0  # m of road over which it rises
LIFT_STEP = 3.0  # m between the points of a lifted edge

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
    return _without(net, lambda connection: way_of(connection) in ways)


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
            points = _lifted(_points(edge, nodes), lifts[edge.attrib["id"]])
            edge.set("shape", " ".join(",".join(f"{v:.2f}" for v in point) for point in points))
    return ElementTree.tostring(root, encoding="unicode")


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


def _without(net: str, doomed: Callable[[Element], bool]) -> str:
    root = ElementTree.fromstring(net)
    for connection in root.findall("connection"):
        if doomed(connection):
            root.remove(connection)
    return ElementTree.tostring(root, encoding="unicode")
