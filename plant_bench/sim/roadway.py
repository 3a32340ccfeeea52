"""Where vehicles drive: how far a place is from the nearest lane's edge."""

import copy

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import resample
from plant_bench.world.town import Town

SPACING = 1.0  # m between the points that stand for a lane; places are met within 0.1 m
NEAR = 25.0  # m around a place within which lanes are looked at


class Roadway:
    """All driving lanes of a town, junctions included; immutable.

    Args:
        town: The town.
    """

    def __init__(self, town: Town) -> None:
        lines = [resample(lane.points[:, :2], SPACING) for lane in town.lanes.values()]
        widths = [lane.width for lane in town.lanes.values()]
        self._points = np.concatenate(lines)
        self._half = 0.5 * np.repeat(widths, [len(line) for line in lines])

    def around(self, x: float, y: float, radius: float) -> "Roadway":
        """Return the part within a square around a place: the rest is not met from there."""
        part = copy.copy(self)
        near = np.abs(self._points - (x, y)).max(axis=1) < radius
        part._points, part._half = self._points[near], self._half[near]
        return part

    def clearance(self, places: Float[np.ndarray, "places 2"]) -> Float[np.ndarray, " places"]:
        """Return the metres from each place to the nearest lane's edge; negative inside lanes.

        The places lie together, within some 20 m of each other.
        """
        middle = places.mean(axis=0)
        near = np.abs(self._points - middle).max(axis=1) < NEAR + np.abs(places - middle).max()
        points, half = self._points[near], self._half[near]
        if not len(points):
            return np.full(len(places), NEAR)
        apart = np.hypot(*np.moveaxis(places[:, None] - points, 2, 0)) - half
        return apart.min(axis=1)
