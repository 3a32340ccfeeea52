"""The pedestrian network of a town: sidewalks, corners between them, and crossings."""

import random
import xml.etree.ElementTree as ET
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.roadside.lane_distance import Roadway

CORNER_CLEARANCE = 0.7  # m between a corner and the road
KERB_CLEARANCE = 0.5  # m between the road and a waiting pedestrian: half a body and a margin
SETBACK_STEP = 0.1  # m
MAX_SETBACK = 4.0  # m before a crossing at which pedestrians wait
JUNCTION_REACH = 60.0  # m around a sidewalk's end in which its turns lie
CROSSING_WEIGHT = 1.0  # weight of crossing the road, relative to turning the corner


@dataclass(frozen=True)
class Crossing:
    """A pedestrian crossing.

    Attributes:
        id: SUMO's edge.
        points: Both ends, x, y, z, at the kerbs.
        width: Metres.
        signal: The signal's id, None where there is none.
        signal_index: Its index in the signal's state, -1 where there is none.
    """

    id: str
    points: tuple[tuple[float, float, float], tuple[float, float, float]]
    width: float
    signal: str | None = None
    signal_index: int = -1


class Heading(NamedTuple):
    """A sidewalk's edge and the direction of walking."""

    edge: str
    forward: bool


class Turn(NamedTuple):
    """A continuation of a walk at a sidewalk's end.

    Attributes:
        onto: The next sidewalk.
        crossing: The crossing between them, None for a corner.
        reverse: Whether the crossing is walked from its second point to its first.
        setback: Distance before the crossing at which pedestrians wait, metres.
    """

    onto: Heading
    crossing: Crossing | None = None
    reverse: bool = False
    setback: float = 0.0


@dataclass(frozen=True, eq=False)
class Footways:
    """The walkable network; immutable.

    Attributes:
        sidewalks: Centre lines by their edges, x, y, z.
        turns: Continuations at each sidewalk's end, without those that lead to dead ends.
    """

    sidewalks: dict[str, Float[np.ndarray, "points 3"]]
    turns: dict[Heading, tuple[Turn, ...]]

    def line(self, heading: Heading) -> Float[np.ndarray, "points 3"]:
        """Return a sidewalk's centre line in the direction of walking."""
        line = self.sidewalks[heading.edge]
        return line if heading.forward else line[::-1]

    def places(self, spacing: float) -> tuple[list[Heading], Float[np.ndarray, "places 3"]]:
        """Return where walks may start, in both directions: sidewalks; x, y and arc length."""
        headings: list[Heading] = []
        spots: list[tuple[float, float, float]] = []
        for heading in sorted(self.turns):
            line = self.line(heading)
            along = arc_lengths(line[:, :2])
            for at in np.arange(0.0, float(along[-1]) - spacing, spacing).tolist():
                headings.append(heading)
                x, y = np.interp(at, along, line[:, 0]), np.interp(at, along, line[:, 1])
                spots.append((float(x), float(y), at))
        return headings, np.array(spots).reshape(-1, 3)

    def walk(self, heading: Heading, draw: random.Random, length: float) -> list[Turn]:
        """Return a random walk of at least `length` metres after a sidewalk."""
        turns: list[Turn] = []
        while length > 0.0:
            onward = self.turns[heading]
            weights = [1.0 if turn.crossing is None else CROSSING_WEIGHT for turn in onward]
            turn = draw.choices(onward, weights)[0]
            turns.append(turn)
            heading = turn.onto
            length -= float(arc_lengths(self.sidewalks[heading.edge][:, :2])[-1])
        return turns


@dataclass
class _Corner:
    """Ends of sidewalks and of crossings (True: the first end) at a walking area."""

    ends: list[Heading] = field(default_factory=list)  # arriving
    crossings: list[tuple[str, bool]] = field(default_factory=list)


def read_footways(net: Path, roadway: Roadway, blocked: Collection[str]) -> Footways:
    """Read the sidewalks and crossings of a SUMO network.

    Args:
        net: The `.net.xml` file.
        roadway: Its driving lanes, which corners keep clear of.
        blocked: Edges whose sidewalks are not used.
    """
    root = ET.parse(net).getroot()
    sidewalks: dict[str, np.ndarray] = {}
    crossings: dict[str, Crossing] = {}
    for edge in root.iter("edge"):
        lane = edge.find("lane")
        if lane is None or lane.get("allow") != "pedestrian":
            continue
        name, line = edge.attrib["id"], _points(lane.attrib["shape"])
        if edge.get("function") == "crossing":
            ends = (_point(line[0]), _point(line[-1]))
            crossings[name] = Crossing(name, ends, float(lane.attrib["width"]))
        elif edge.get("function") is None and name not in blocked:
            sidewalks[name] = line
    corners: dict[str, _Corner] = {}
    for way in root.iter("connection"):
        _join(way.attrib, sidewalks, crossings, corners)
    draft = Footways(sidewalks, {})
    turns: dict[Heading, tuple[Turn, ...]] = {}
    for name in sorted(corners):
        for end in corners[name].ends:
            x, y, _ = draft.line(end)[-1].tolist()
            near = roadway.around(x, y, JUNCTION_REACH)
            turns[end] = tuple(_turns(draft, end, name, corners, crossings, near))
    return Footways(sidewalks, _without_dead_ends(turns))


def _points(shape: str) -> Float[np.ndarray, "points 3"]:
    places = [[float(value) for value in place.split(",")] for place in shape.split()]
    return np.array([(*place, 0.0)[:3] for place in places])


def _point(place: Float[np.ndarray, " 3"]) -> tuple[float, float, float]:
    x, y, z = place.tolist()
    return x, y, z


def _join(
    way: dict[str, str],
    sidewalks: Collection[str],
    crossings: dict[str, Crossing],
    corners: dict[str, _Corner],
) -> None:
    """Record what a connection of the network joins to a walking area."""
    source, target = way["from"], way["to"]
    if source in sidewalks and "_w" in target:
        corners.setdefault(target, _Corner()).ends.append(Heading(source, forward=True))
    elif target in sidewalks and "_w" in source:
        corners.setdefault(source, _Corner()).ends.append(Heading(target, forward=False))
    elif target in crossings:
        corners.setdefault(source, _Corner()).crossings.append((target, True))
        old, signal = crossings[target], way.get("tl")
        index = int(way.get("linkIndex", -1))
        crossings[target] = Crossing(old.id, old.points, old.width, signal, index)
    elif source in crossings:
        corners.setdefault(target, _Corner()).crossings.append((source, False))


def _turns(
    ways: Footways,
    end: Heading,
    name: str,
    corners: dict[str, _Corner],
    crossings: dict[str, Crossing],
    roadway: Roadway,
) -> list[Turn]:
    """Return the continuations at a sidewalk's end: around the corner, or over one crossing."""
    place = ways.line(end)[-1]
    found = [
        Turn(onto)
        for onto in map(_leaving, corners[name].ends)
        if onto.edge != end.edge and _keeps_off(place, ways.line(onto)[0], roadway)
    ]
    for edge, first in corners[name].crossings:
        crossing = crossings[edge]
        near, far = crossing.points if first else crossing.points[::-1]
        setback = _setback(place, np.array(near), roadway)
        beyond = next(
            (item for item in corners.values() if (edge, not first) in item.crossings), _Corner()
        )
        if setback is None:
            continue
        for onto in map(_leaving, beyond.ends):
            if _setback(ways.line(onto)[0], np.array(far), roadway) is not None:
                found.append(Turn(onto, crossing, not first, setback))
    return found


def _leaving(arriving: Heading) -> Heading:
    return Heading(arriving.edge, not arriving.forward)


def _keeps_off(one: np.ndarray, other: np.ndarray, roadway: Roadway) -> bool:
    share = np.linspace(0.0, 1.0, 12)[:, None]
    return bool((roadway.clearance((one + share * (other - one))[:, :2]) > CORNER_CLEARANCE).all())


def _setback(place: np.ndarray, kerb: np.ndarray, roadway: Roadway) -> float | None:
    """Return the distance before the kerb for waiting off the road; None if impossible."""
    way = float(np.hypot(*(kerb - place)[:2]))
    back = np.arange(0.0, min(way, MAX_SETBACK) + 1e-6, SETBACK_STEP)
    places = kerb + (back / max(way, 1e-6))[:, None] * (place - kerb)
    free = np.flatnonzero(roadway.clearance(places[:, :2]) > KERB_CLEARANCE)
    if not free.size or not _free_before(place, places[free[0]], roadway):
        return None
    return float(back[free[0]])


def _free_before(place: np.ndarray, waiting: np.ndarray, roadway: Roadway) -> bool:
    share = np.linspace(0.0, 1.0, 8)[:, None]
    places = (place + share * (waiting - place))[:, :2]
    return bool((roadway.clearance(places) > KERB_CLEARANCE - 0.15).all())


def _without_dead_ends(turns: dict[Heading, tuple[Turn, ...]]) -> dict[Heading, tuple[Turn, ...]]:
    """Return the turns without those that lead to a dead end."""
    while True:
        kept = {
            end: tuple(turn for turn in onward if turns.get(turn.onto))
            for end, onward in turns.items()
        }
        if kept == turns:
            return {end: onward for end, onward in turns.items() if onward}
        turns = kept
