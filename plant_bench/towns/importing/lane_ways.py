"""A town's lanes as a graph: which lane a point may be on, and how far it is from place to place."""

from functools import cached_property, lru_cache
from typing import NamedTuple

import networkx as nx
import numpy as np
import shapely
from shapely.geometry import LineString, Point

from plant_bench.world.town import Town

REACH = 6000.0  # m that ways between two points of a route may be long
CHANGE = 10.0  # m of way that a lane change counts for, more on short lanes
CHANGE_ON_SHORT = 300.0  # m2


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


class LaneWays:
    """Where lanes are and lead; answers are kept."""

    def __init__(self, town: Town) -> None:
        self.town = town
        self._lanes = [lane for lane in town.lanes.values() if lane.length > 0.01]
        self._lines = [LineString(lane.points[:, :2]) for lane in self._lanes]
        self._tree = shapely.STRtree(self._lines)
        self.from_lane = lru_cache(maxsize=None)(self._from_lane)

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

    def _from_lane(self, lane: str) -> tuple[dict[str, float], dict[str, list[str]]]:
        """Metres from a lane's begin to others' begins, and the lanes on the way."""
        return nx.single_source_dijkstra(self._graph, lane, cutoff=REACH, weight="way")
