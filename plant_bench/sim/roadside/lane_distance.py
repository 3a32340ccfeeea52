"""Distance from points to the edge of the nearest driving lane."""

import copy

import numpy as np
from jaxtyping import Float, Int

from plant_bench.geometry.polyline import resample
from plant_bench.world.town import Town

SPACING = 1.0  # m between the points that represent a lane; accuracy 0.1 m
NEAR = 25.0  # m around a point within which lanes are considered
BESIDE = 6.0  # m around it within which the nearest lane mostly is; searched first


class Roadway:
    """All driving lanes of a town, junctions included; immutable.

    Args:
        town: The town.
    """

    def __init__(self, town: Town) -> None:
        lines = [resample(lane.points[:, :2], SPACING) for lane in town.lanes.values()]
        widths = [lane.width for lane in town.lanes.values()]
        self._x, self._y = np.concatenate(lines).T.copy()
        self._half = 0.5 * np.repeat(widths, [len(line) for line in lines])
        self._widest = 0.5 * max(widths)

    def around(self, x: float, y: float, radius: float) -> "Roadway":
        """Return the part within a square around a place, for queries near it."""
        part = copy.copy(self)
        near = self._within(x, y, radius)
        part._x, part._y, part._half = self._x[near], self._y[near], self._half[near]
        return part

    def clearance(self, places: Float[np.ndarray, "places 2"]) -> Float[np.ndarray, " places"]:
        """Return the distance from each place to the nearest lane's edge; negative inside lanes.

        The places must be within about 20 m of each other.
        """
        x, y = places.mean(axis=0)
        extent = np.abs(places - (x, y)).max()
        beside = self._clearance(places, self._within(x, y, BESIDE + extent))
        if beside.max() <= BESIDE - self._widest:  # whatever lies beyond is farther from each
            return beside
        return self._clearance(places, self._within(x, y, NEAR + extent))

    def _clearance(self, places: np.ndarray, near: np.ndarray) -> np.ndarray:
        if not len(near):
            return np.full(len(places), NEAR)
        dx = places[:, 0, None] - self._x[near]
        dy = places[:, 1, None] - self._y[near]
        return (np.hypot(dx, dy) - self._half[near]).min(axis=1)

    def _within(self, x: float, y: float, reach: float) -> Int[np.ndarray, " near"]:
        """Return the indices of points in a square of side 2 `reach` around a place."""
        near = (np.abs(self._x - x) < reach).nonzero()[0]
        return near[np.abs(self._y[near] - y) < reach]
