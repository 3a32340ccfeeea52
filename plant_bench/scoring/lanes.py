"""Lane check: is a vehicle off all driving lanes of a town, or on one against its direction?"""

import math
from enum import StrEnum
from functools import lru_cache

import numpy as np
import shapely

from plant_bench.world.town import Town

# OutsideRouteLanesTest of scenario_runner 1.0, atomic_criteria.py.
LANE_MARGIN = 1.3  # m beyond half a lane's width (ALLOWED_OUT_DISTANCE)
WRONG_WAY = math.radians(120.0)  # (MAX_ALLOWED_VEHICLE_LANE_ANGLE)
LEVEL = 3.0  # m of height: own choice, distinguishes a bridge from the road below


class LaneFault(StrEnum):
    """Ways to be outside the lanes."""

    OFF_LANE = "off_lane"
    WRONG_LANE = "wrong_lane"  # on a lane, against its direction


class LaneMap:
    """The driving lanes of a town, those inside junctions included.

    Args:
        town: The town.
    """

    def __init__(self, town: Town) -> None:
        lanes = [lane for lane in town.lanes.values() if len(lane.points) > 1]
        counts = [len(lane.points) - 1 for lane in lanes]
        self._start = np.concatenate([lane.points[:-1] for lane in lanes])
        self._delta = np.concatenate([np.diff(lane.points, axis=0) for lane in lanes])
        self._square = np.maximum((self._delta[:, :2] ** 2).sum(axis=1), 1e-12)
        self._yaw = np.arctan2(self._delta[:, 1], self._delta[:, 0])
        self._limit = np.repeat([0.5 * lane.width + LANE_MARGIN for lane in lanes], counts)
        self._internal = np.repeat([lane.junction is not None for lane in lanes], counts)
        self._reach = float(self._limit.max())
        ends = np.stack((self._start[:, :2], (self._start + self._delta)[:, :2]), axis=1)
        self._segments = shapely.STRtree(np.asarray(shapely.linestrings(ends)))
        outlines = [item.outline for item in town.junctions.values() if len(item.outline) > 2]
        self._junctions = shapely.STRtree([shapely.Polygon(outline) for outline in outlines])

    def outside(self, x: float, y: float, z: float, yaw: float) -> bool:
        """Return whether a vehicle has a lane fault; see `fault`."""
        return self.fault(x, y, z, yaw) is not None

    def fault(self, x: float, y: float, z: float, yaw: float) -> LaneFault | None:
        """Return whether a vehicle's centre is off all lanes, or it drives against the nearest one.

        Directions are not checked inside junctions.

        Args:
            x: Metres.
            y: Metres.
            z: The height of the road there, metres; lanes on another level do not count.
            yaw: The vehicle's heading.
        """
        point = shapely.points(x, y)
        near = self._segments.query(point, predicate="dwithin", distance=self._reach)
        near.sort()
        start, delta = self._start[near], self._delta[near]
        px, py = x - start[:, 0], y - start[:, 1]
        share = ((px * delta[:, 0] + py * delta[:, 1]) / self._square[near]).clip(0.0, 1.0)
        distance = np.hypot(px - share * delta[:, 0], py - share * delta[:, 1])
        distance[np.abs(start[:, 2] + share * delta[:, 2] - z) > LEVEL] = np.inf
        if not near.size or not np.isfinite(distance).any():
            return LaneFault.OFF_LANE
        nearest = int(distance.argmin())
        lane = near[nearest]
        if distance[nearest] > self._limit[lane]:
            return LaneFault.OFF_LANE
        if self._internal[lane] or math.cos(yaw - self._yaw[lane]) >= math.cos(WRONG_WAY):
            return None
        if self._junctions.query(point, predicate="intersects").size:
            return None
        return LaneFault.WRONG_LANE


@lru_cache(maxsize=8)
def lane_map(town: Town) -> LaneMap:
    """Return the town's lane map, built once."""
    return LaneMap(town)
