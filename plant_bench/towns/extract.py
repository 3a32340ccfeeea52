"""Converts a SUMO network to a Town.

Apart from SUMO itself, only this module and `sim.roadside.footways` (sidewalks and crossings) read
`town.net.xml`.
"""

from collections.abc import Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from plant_bench.world.town import Area, Junction, Lane, Link, Town

TURNS = {"s": "straight", "l": "left", "L": "left", "r": "right", "R": "right"}
CONTROLS = {"M": "major", "m": "minor", "s": "stop", "w": "allway", "=": "equal", "Z": "zipper"}
KINDS = {
    "traffic_light": "signal",
    "priority_stop": "stop",
    "allway_stop": "allway",
    "right_before_left": "right_before_left",
    "zipper": "zipper",
}
AREAS = {"crossing": "crossing", "walkingarea": "walking area"}


def extract_town(net: str, name: str) -> Town:
    """Read a SUMO net (XML text) into a Town."""
    root = ElementTree.fromstring(net)
    connections = root.findall("connection")
    edges = root.findall("edge")
    driving = {
        lane.attrib["id"]: (edge, lane)
        for edge in edges
        if edge.get("function") not in AREAS
        for lane in edge.findall("lane")
        if carries_cars(lane.attrib)
    }
    links = _links(connections, driving)
    rings = [tuple(ring.attrib["edges"].split()) for ring in root.findall("roundabout")]
    return Town(
        name=name,
        lanes=_lanes(driving, connections),
        links=links,
        junctions=_junctions(root, edges, links, rings),
        signals=_signals(links),
        roundabouts=tuple(rings),
        areas=_areas(edges),
    )


def carries_cars(lane: Mapping[str, str]) -> bool:
    """Return whether cars may drive on a lane, given its attributes in the network."""
    allowed, banned = lane.get("allow", "all").split(), lane.get("disallow", "").split()
    return not {"passenger", "all"}.isdisjoint(allowed) and {"passenger", "all"}.isdisjoint(banned)


def _is_sidewalk(lane: Element) -> bool:
    return lane.get("allow") == "pedestrian"


def _lanes(
    driving: dict[str, tuple[Element, Element]], connections: list[Element]
) -> dict[str, Lane]:
    followers: dict[str, list[str]] = {name: [] for name in driving}
    for connection in connections:
        start = f"{connection.attrib['from']}_{connection.attrib['fromLane']}"
        onward = connection.get("via", f"{connection.attrib['to']}_{connection.attrib['toLane']}")
        if start in driving and onward in driving and onward not in followers[start]:
            followers[start].append(onward)
    return {name: _lane(*driving[name], followers, driving) for name in driving}


def _lane(
    edge: Element,
    lane: Element,
    followers: dict[str, list[str]],
    driving: dict[str, tuple[Element, Element]],
) -> Lane:
    edge_id, index = edge.attrib["id"], int(lane.attrib["index"])
    successors = tuple(followers[lane.attrib["id"]])
    left, right = f"{edge_id}_{index + 1}", f"{edge_id}_{index - 1}"
    internal = edge.get("function") == "internal"
    return Lane(
        id=lane.attrib["id"],
        edge=edge_id,
        index=index,
        points=_points(lane.attrib["shape"]),
        width=float(lane.get("width", "3.2")),
        speed_limit=float(lane.attrib["speed"]),
        junction=edge_id[1:].rsplit("_", 1)[0] if internal else None,
        successors=successors,
        left=left if left in driving and not internal else None,
        right=right if right in driving and not internal else None,
        acceleration=not successors and any(followers.get(side) for side in (left, right)),
    )


def _points(shape: str) -> np.ndarray:
    points = [[float(v) for v in point.split(",")] for point in shape.split()]
    return np.array([[*point, 0.0][:3] for point in points])


def _links(
    connections: list[Element], driving: dict[str, tuple[Element, Element]]
) -> tuple[Link, ...]:
    inside = {
        f"{c.attrib['from']}_{c.attrib['fromLane']}": c
        for c in connections
        if c.attrib["from"].startswith(":")
    }
    links = []
    for connection in connections:
        source = f"{connection.attrib['from']}_{connection.attrib['fromLane']}"
        target = f"{connection.attrib['to']}_{connection.attrib['toLane']}"
        if source.startswith(":") or source not in driving or target not in driving:
            continue
        via = _via(connection, inside)
        links.append(_link(connection, source, target, via, driving))
    return tuple(links)


def _via(connection: Element, inside: dict[str, Element]) -> tuple[str, ...]:
    via: list[str] = []
    step: Element | None = connection
    while step is not None and step.get("via"):
        via.append(step.attrib["via"])
        step = inside.get(via[-1])
    return tuple(via)


def _link(
    connection: Element,
    source: str,
    target: str,
    via: tuple[str, ...],
    driving: dict[str, tuple[Element, Element]],
) -> Link:
    signal = connection.get("tl")
    control = "signal" if signal else CONTROLS.get(connection.attrib["state"], "minor")
    return Link(
        source=source,
        target=target,
        via=via,
        junction=driving[source][0].attrib["to"],
        turn=TURNS.get(connection.attrib["dir"], "left"),
        control=control,
        signal=signal,
        signal_index=int(connection.get("linkIndex", "-1")) if signal else -1,
    )


def _signals(links: tuple[Link, ...]) -> dict[str, int]:
    """Return each signal's number of vehicle links; crossings come after them in its state.

    Links that were removed from a network keep their position in the state.
    """
    found: dict[str, int] = {}
    for link in links:
        if link.signal is not None:
            found[link.signal] = max(found.get(link.signal, 0), link.signal_index + 1)
    return dict(sorted(found.items()))


def _junctions(
    root: Element, edges: list[Element], links: tuple[Link, ...], rings: list[tuple[str, ...]]
) -> dict[str, Junction]:
    ring_edges = {edge for ring in rings for edge in ring}
    ends = {e.attrib["id"]: (e.attrib["from"], e.attrib["to"]) for e in edges if "from" in e.attrib}
    on_ring = {place for edge in ring_edges for place in ends[edge]}
    yielding = {link.junction for link in links if link.control != "major"}
    found = {}
    for junction in root.findall("junction"):
        name, kind = junction.attrib["id"], junction.attrib["type"]
        if kind == "internal":
            continue
        if name in on_ring:
            kind = "roundabout"
        elif name not in yielding:
            kind = "joint"
        else:
            kind = KINDS.get(kind, "priority")
        outline = _points(junction.get("shape", ""))[:, :2] if junction.get("shape") else []
        found[name] = Junction(
            id=name,
            kind=kind,
            x=float(junction.attrib["x"]),
            y=float(junction.attrib["y"]),
            arms=_arms(name, ends),
            outline=tuple((float(x), float(y)) for x, y in outline),
        )
    return found


def _arms(junction: str, ends: dict[str, tuple[str, str]]) -> int:
    """Count a junction's arms: a two-way street is one arm; one-way edges count each."""
    out = sorted(end for start, end in ends.values() if start == junction)
    into = sorted(start for start, end in ends.values() if end == junction)
    both = 0
    for place in list(out):
        if place in into:
            into.remove(place)
            both += 1
    return len(out) + len(into)


def _areas(edges: list[Element]) -> tuple[Area, ...]:
    areas = []
    for edge in edges:
        kind = AREAS.get(edge.get("function", ""))
        for lane in edge.findall("lane"):
            points = _points(lane.attrib["shape"])[:, :2]
            if kind == "walking area":
                areas.append(Area(kind, _outline(points)))
            elif kind or _is_sidewalk(lane):
                width = float(lane.get("width", "2.0"))
                areas.append(Area(kind or "sidewalk", _outline(_ribbon(points, width))))
    return tuple(areas)


def _outline(points: np.ndarray) -> tuple[tuple[float, float], ...]:
    return tuple((round(float(x), 2), round(float(y), 2)) for x, y in points)


def _ribbon(points: np.ndarray, width: float) -> np.ndarray:
    """Return the outline of a strip along a line."""
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-9)[:, None]
    across = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1) * width / 2
    return np.concatenate([points + across, (points - across)[::-1]])
