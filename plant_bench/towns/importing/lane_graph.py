"""A town's lanes as a graph: which of them a point may be on, and the ways between places."""

from collections.abc import Iterator
from functools import cached_property, lru_cache
from typing import NamedTuple

import networkx as nx
import numpy as np
import shapely
from shapely.geometry import LineString, Point

from plant_bench.world.town import Town

REACH = 3000.0  # m that a way between two points of a route may be long
CHANGE = 10.0  # m of way that a lane change counts for, more on short lanes
CHANGE_ON_SHORT = 300.0  # m2
CHANGE_ROOM = 25.0  # m of road that a lane change takes
CRAMPED = 3.0  # metres of way that each missing metre of it counts for
BACK = 2.0  # m that the next place may lie behind, where points are dense


class OnLane(NamedTuple):
    """A place on a lane.

    Attributes:
        lane: The lane.
        at: Metres along it.
        away: Metres from the point it was found for, in the plane.
        heading: Of the lane there, radians.
        z: Of the lane there, metres.
    """

    lane: str
    at: float
    away: float
    heading: float
    z: float


class Way(NamedTuple):
    """A way from place to place.

    Attributes:
        metres: Its length, lane changes counted as metres.
        lanes: In order, both ends included.
    """

    metres: float
    lanes: tuple[str, ...]


class LaneGraph:
    """Where lanes are and lead; answers are kept."""

    def __init__(self, town: Town) -> None:
        self.town = town
        self._lanes = [lane for lane in town.lanes.values() if lane.length > 0.01]
        self._lines = [LineString(lane.points[:, :2]) for lane in self._lanes]
        self._tree = shapely.STRtree(self._lines)
        self._from_lane = lru_cache(maxsize=None)(self._search)

    @cached_property
    def has_levels(self) -> bool:
        """Whether the town's heights tell anything."""
        heights = np.concatenate([lane.points[:, 2] for lane in self._lanes])
        return bool(np.ptp(heights) > 1.0)

    def near(self, x: float, y: float, radius: float) -> list[OnLane]:
        """Return the nearest place of each lane within `radius` metres."""
        point = Point(x, y)
        found = []
        for index in sorted(self._tree.query(point, predicate="dwithin", distance=radius).tolist()):
            lane, line = self._lanes[index], self._lines[index]
            at = float(line.project(point))
            step = min(int(np.searchsorted(lane.along, at, side="right")), len(lane.along) - 1)
            delta = lane.points[step] - lane.points[step - 1]
            heading = float(np.arctan2(delta[1], delta[0]))
            z = float(np.interp(at, lane.along, lane.points[:, 2]))
            found.append(OnLane(lane.id, at, float(line.distance(point)), heading, z))
        return found

    def distance_to_nearest(self, x: float, y: float) -> float:
        """Return how far the nearest lane is, metres."""
        return float(self._lines[int(self._tree.nearest(Point(x, y)))].distance(Point(x, y)))

    def way(self, start: OnLane, goal: OnLane) -> Way | None:
        """Return the shortest way from place to place; None where there is none.

        Lane changes without room count for more, so that they are made before or after.
        """
        found = [
            Way(metres + goal.at - start.at, lanes)
            for may_change in (True, False)
            for metres, lanes in self._arrivals(start.lane, goal.lane, may_change)
        ]
        forward = [way for way in found if self._is_forward(way, start, goal)]
        if not forward:
            return None
        return min(forward, key=lambda way: way.metres + self._cramped(way, start, goal))

    def _is_forward(self, way: Way, start: OnLane, goal: OnLane) -> bool:
        edges = {self.town.lanes[lane].edge for lane in way.lanes}
        return way.metres >= -BACK and (len(edges) > 1 or goal.at >= start.at - BACK)

    def _cramped(self, way: Way, start: OnLane, goal: OnLane) -> float:
        """Metres that the way counts for more, since lane changes at its ends have no room."""
        edges = [self.town.lanes[lane].edge for lane in way.lanes]
        first = edges.count(edges[0]) - 1
        last = edges.count(edges[-1]) - 1 if edges[-1] != edges[0] else 0
        ahead = self.town.lanes[start.lane].length if len(set(edges)) > 1 else goal.at
        room = ((first, ahead - start.at), (last, goal.at))
        return sum(max(0.0, count * CHANGE_ROOM - metres) * CRAMPED for count, metres in room)

    def _arrivals(
        self, start: str, goal: str, may_change: bool
    ) -> Iterator[tuple[float, tuple[str, ...]]]:
        """Ways from begin to begin: the shortest, and those that do not end in a lane change."""
        metres, lanes = self._from_lane(start, may_change)
        if goal in metres:
            yield metres[goal], tuple(lanes[goal])
        for before in self._graph.predecessors(goal):
            if before in metres and goal in self.town.lanes[before].successors:
                way = metres[before] + self.town.lanes[before].length
                yield way, (*lanes[before], goal)

    @cached_property
    def _graph(self) -> nx.DiGraph:
        graph = nx.DiGraph()
        for lane in self.town.lanes.values():
            graph.add_node(lane.id)
            for onward in lane.successors:
                graph.add_edge(lane.id, onward, way=lane.length)
            for beside in (lane.left, lane.right):
                if beside is not None:
                    way = CHANGE + CHANGE_ON_SHORT / max(lane.length, 5.0)
                    graph.add_edge(lane.id, beside, way=way)
        return graph

    def _search(self, lane: str, may_change: bool) -> tuple[dict[str, float], dict[str, list[str]]]:
        """Metres from a lane's begin to others' begins, and the lanes on the way."""
        beside = {self.town.lanes[lane].left, self.town.lanes[lane].right}

        def metres(one: str, other: str, data: dict[str, float]) -> float | None:
            return None if not may_change and one == lane and other in beside else data["way"]

        predecessors, metres_to = nx.dijkstra_predecessor_and_distance(
            self._graph, lane, cutoff=REACH, weight=metres
        )
        found = {name: float(way) for name, way in metres_to.items()}
        lanes: dict[str, list[str]] = {}
        for name in found:  # nearer lanes come first
            before = predecessors[name]
            lanes[name] = [*lanes[before[0]], name] if before else [name]
        return found, lanes
