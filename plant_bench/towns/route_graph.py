"""A town's edges as a graph for route generation, with its junctions, merges and exits."""

from collections import defaultdict
from functools import cached_property

import numpy as np

from plant_bench.geometry.polyline import headings
from plant_bench.world.town import Lane, Link, Town

START_AFTER = 10.0  # m from the last junction to a route's start
ROOM_AHEAD = 25.0  # m of the first edge that must remain ahead of the start
END_MARGIN = 15.0  # m from the destination to the previous and the next junction
EXIT_SPEED = 16.0  # m/s: minimum speed limit of a road with exits
U_TURN_ANGLE = 2.5  # rad: minimum change of heading of a U-turn's edge
U_TURN_LENGTH = 120.0  # m: longer edges that turn back are bends, not U-turns


class StreetGraph:
    """A town's edges and the links between them; built once per town.

    Attributes:
        town: The town.
        lengths: Length of each edge (of its rightmost lane), metres.
        ring_edges: The edges of roundabouts.
        u_turns: The edges of U-turns, such as those over a median.
        onward: The successors of each edge.
        junctions: The junction at the end of each edge.
    """

    def __init__(self, town: Town) -> None:
        self.town = town
        self.lengths = {edge: lanes[0].length for edge, lanes in town.edges.items()}
        self.ring_edges = frozenset(edge for ring in town.roundabouts for edge in ring)
        self.onward: dict[str, tuple[str, ...]] = dict.fromkeys(town.edges, ())
        self.junctions: dict[str, str] = {}
        self._links: dict[tuple[str, str], list[Link]] = defaultdict(list)
        arriving: dict[str, set[str]] = defaultdict(set)
        leaving: dict[str, set[str]] = defaultdict(set)
        for link in town.links:
            before, after = town.lanes[link.source].edge, town.lanes[link.target].edge
            self._links[before, after].append(link)
            self.junctions[before] = link.junction
            arriving[link.junction].add(before)
            leaving[link.junction].add(after)
        for before, after in self._links:
            self.onward[before] = (*self.onward[before], after)
        self._arriving = {junction: frozenset(edges) for junction, edges in arriving.items()}
        self._leaving = {junction: frozenset(edges) for junction, edges in leaving.items()}
        self.u_turns = frozenset(edge for edge in town.edges if self._turns_back(edge))

    def links(self, before: str, after: str) -> list[Link]:
        """Return the links from one edge to another."""
        return self._links.get((before, after), [])

    def is_joint(self, junction: str) -> bool:
        """Return whether edges just join at a junction, without any conflict."""
        return self.town.junctions[junction].kind == "joint"

    def is_crossing(self, junction: str) -> bool:
        """Return whether several roads lead to and from a junction that is not on a roundabout."""
        several = len(self._arriving[junction]) > 1 and len(self._leaving[junction]) > 1
        return several and not self.ring_edges & self._arriving[junction]

    def is_exit(self, before: str, after: str) -> bool:
        """Return whether an edge leads to another by an exit on the right of a fast road."""
        junction = self.junctions[before]
        others = self._leaving[junction] - {after}
        if len(self._arriving[junction]) > 1 or not others or before in self.ring_edges:
            return False
        if self.town.edges[before][0].speed_limit < EXIT_SPEED:
            return False
        rightmost = self.town.edges[before][0].id
        return any(link.source == rightmost for link in self.links(before, after)) and not any(
            link.source == rightmost for other in others for link in self.links(before, other)
        )

    def has_acceleration(self, edge: str) -> bool:
        """Return whether the edge has an acceleration lane."""
        return any(lane.acceleration for lane in self.town.edges[edge])

    @cached_property
    def landmarks(self) -> tuple[str, ...]:
        """The edges of roundabouts, U-turns, acceleration lanes and exits, in the town's order."""
        exits = {after for before, after in self._links if self.is_exit(before, after)}
        return tuple(
            edge
            for edge in self.town.edges
            if edge in self.ring_edges
            or edge in self.u_turns
            or edge in exits
            or self.has_acceleration(edge)
        )

    @cached_property
    def starts(self) -> tuple[str, ...]:
        """The edges on which a route may start: long enough, and not leading to an exit."""
        return tuple(
            edge
            for edge in self._plain
            if self.lengths[edge] >= START_AFTER + ROOM_AHEAD
            and not any(self.is_exit(edge, onward) for onward in self.onward[edge])
        )

    @cached_property
    def ends(self) -> tuple[str, ...]:
        """The edges on which a route may end."""
        return tuple(e for e in self._plain if self.lengths[e] > 2.0 * END_MARGIN)

    @cached_property
    def _plain(self) -> tuple[str, ...]:
        return tuple(
            edge
            for edge in self.town.edges
            if self.onward[edge]
            and edge not in self.ring_edges
            and edge not in self.u_turns
            and not self.has_acceleration(edge)
        )

    def _turns_back(self, edge: str) -> bool:
        lane = self.town.edges[edge][0]
        return lane.length < U_TURN_LENGTH and abs(_turned(lane)) > U_TURN_ANGLE


def _turned(lane: Lane) -> float:
    steps = np.hypot(*np.diff(lane.points[:, :2], axis=0).T) > 0.05
    yaw = headings(lane.points[np.concatenate(([True], steps)), :2])
    return float(yaw[-1] - yaw[0])
