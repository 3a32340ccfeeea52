"""Finds the lanes near a point, and shortest paths between positions on a town's lanes."""

from collections.abc import Iterator
from functools import cached_property, lru_cache
from typing import NamedTuple

import networkx as nx
import numpy as np
import shapely
from shapely.geometry import LineString, Point

from plant_bench.world.town import Town

MAX_PATH_LENGTH = 3000.0  # m between two points of a route
CHANGE_COST = 10.0  # m of path length that a lane change adds; more on short lanes
SHORT_LANE_COST = 300.0  # m2, divided by the lane's length
CHANGE_LENGTH = 25.0  # m of road that a lane change takes
SHORTAGE_COST = 3.0  # m of path length added per metre that is missing for a lane change
BACKWARD_TOLERANCE = 2.0  # m that the next position may lie behind, where points are dense


class LanePosition(NamedTuple):
    """A position on a lane, found for a point.

    Attributes:
        lane: Lane id.
        at: Arc length on the lane, metres.
        away: Distance from the point in the plane, metres.
        heading: Heading of the lane there, radians.
        z: Height of the lane there, metres.
    """

    lane: str
    at: float
    away: float
    heading: float
    z: float


class LanePath(NamedTuple):
    """A path between two positions.

    Attributes:
        metres: Length with the cost of lane changes, metres.
        lanes: Lane ids in order, both ends included.
    """

    metres: float
    lanes: tuple[str, ...]


class LaneGraph:
    """Positions and connections of a town's lanes; searches are cached."""

    def __init__(self, town: Town) -> None:
        self.town = town
        self._lanes = [lane for lane in town.lanes.values() if lane.length > 0.01]
        self._lines = [LineString(lane.points[:, :2]) for lane in self._lanes]
        self._tree = shapely.STRtree(self._lines)
        self._from_lane = lru_cache(maxsize=None)(self._search)

    @cached_property
    def has_levels(self) -> bool:
        """Whether the town's lanes differ in height."""
        heights = np.concatenate([lane.points[:, 2] for lane in self._lanes])
        return bool(np.ptp(heights) > 1.0)

    def near(self, x: float, y: float, radius: float) -> list[LanePosition]:
        """Return the nearest position on each lane within `radius` metres of a point."""
        point = Point(x, y)
        found = []
        for index in sorted(self._tree.query(point, predicate="dwithin", distance=radius).tolist()):
            lane, line = self._lanes[index], self._lines[index]
            at = float(line.project(point))
            step = min(int(np.searchsorted(lane.along, at, side="right")), len(lane.along) - 1)
            delta = lane.points[step] - lane.points[step - 1]
            heading = float(np.arctan2(delta[1], delta[0]))
            z = float(np.interp(at, lane.along, lane.points[:, 2]))
            found.append(LanePosition(lane.id, at, float(line.distance(point)), heading, z))
        return found

    def distance_to_nearest(self, x: float, y: float) -> float:
        """Return the distance to the nearest lane, metres."""
        return float(self._lines[int(self._tree.nearest(Point(x, y)))].distance(Point(x, y)))

    def shortest_path(self, start: LanePosition, goal: LanePosition) -> LanePath | None:
        """Return the shortest path between two positions, or None if there is none.

        A lane change too close to either end costs more, so that it is made before or after.
        """
        found = [
            LanePath(metres + goal.at - start.at, lanes)
            for may_change in (True, False)
            for metres, lanes in self._arrivals(start.lane, goal.lane, may_change)
        ]
        forward = [path for path in found if self._is_forward(path, start, goal)]
        if not forward:
            return None
        return min(forward, key=lambda path: path.metres + self._shortage_cost(path, start, goal))

    def _is_forward(self, path: LanePath, start: LanePosition, goal: LanePosition) -> bool:
        edges = {self.town.lanes[lane].edge for lane in path.lanes}
        return path.metres >= -BACKWARD_TOLERANCE and (
            len(edges) > 1 or goal.at >= start.at - BACKWARD_TOLERANCE
        )

    def _shortage_cost(self, path: LanePath, start: LanePosition, goal: LanePosition) -> float:
        """Return the extra cost of lane changes that are too close to either end, metres."""
        edges = [self.town.lanes[lane].edge for lane in path.lanes]
        first = edges.count(edges[0]) - 1
        last = edges.count(edges[-1]) - 1 if edges[-1] != edges[0] else 0
        ahead = self.town.lanes[start.lane].length if len(set(edges)) > 1 else goal.at
        available = ((first, ahead - start.at), (last, goal.at))
        return sum(
            max(0.0, count * CHANGE_LENGTH - metres) * SHORTAGE_COST for count, metres in available
        )

    def _arrivals(
        self, start: str, goal: str, may_change: bool
    ) -> Iterator[tuple[float, tuple[str, ...]]]:
        """Yield paths between lane starts: the shortest, and those that do not end in a change."""
        metres, lanes = self._from_lane(start, may_change)
        if goal in metres:
            yield metres[goal], tuple(lanes[goal])
        for before in self._graph.predecessors(goal):
            if before in metres and goal in self.town.lanes[before].successors:
                length = metres[before] + self.town.lanes[before].length
                yield length, (*lanes[before], goal)

    @cached_property
    def _graph(self) -> nx.DiGraph:
        graph = nx.DiGraph()
        for lane in self.town.lanes.values():
            graph.add_node(lane.id)
            for onward in lane.successors:
                graph.add_edge(lane.id, onward, length=lane.length)
            for beside in (lane.left, lane.right):
                if beside is not None:
                    length = CHANGE_COST + SHORT_LANE_COST / max(lane.length, 5.0)
                    graph.add_edge(lane.id, beside, length=length)
        return graph

    def _search(self, lane: str, may_change: bool) -> tuple[dict[str, float], dict[str, list[str]]]:
        """Return the distance from a lane's start to other lanes' starts, and the lanes between."""
        beside = {self.town.lanes[lane].left, self.town.lanes[lane].right}

        def metres(one: str, other: str, data: dict[str, float]) -> float | None:
            return None if not may_change and one == lane and other in beside else data["length"]

        predecessors, metres_to = nx.dijkstra_predecessor_and_distance(
            self._graph, lane, cutoff=MAX_PATH_LENGTH, weight=metres
        )
        found = {name: float(length) for name, length in metres_to.items()}
        lanes: dict[str, list[str]] = {}
        for name in found:  # nearer lanes come first
            before = predecessors[name]
            lanes[name] = [*lanes[before[0]], name] if before else [name]
        return found, lanes
