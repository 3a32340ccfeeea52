"""A town's road surface and lane lines as one image, from which windows around the ego are cut.

Drawn once per town and scale; a window then takes a fraction of a millisecond, whatever the number
of lanes. Planners may use the map (Roach and AIM-BEV do): it is not privileged.
"""

import math
from functools import lru_cache

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageDraw

from plant_bench.world.scene import EgoState
from plant_bench.world.town import Lane, Town

ROAD, BROKEN, SOLID = 1, 2, 4  # bits of a pixel
LINE_WIDTH = 0.3  # m: one or two pixels at Roach's 5 per metre
MARGIN = 10.0  # m of background around the outermost lanes
FULL, CROSSABLE = 255, 120  # Roach: solid lines, broken lines

ROAD_VALUES = np.array([FULL * (code & ROAD) for code in range(8)], np.uint8)
LINE_VALUES = np.array(
    [FULL if code & SOLID else CROSSABLE if code & BROKEN else 0 for code in range(8)], np.uint8
)


class RoadMap:
    """An image of a town's roads; immutable.

    Args:
        town: The town.
        scale: Pixels per metre.
    """

    def __init__(self, town: Town, scale: float) -> None:
        points = np.concatenate([lane.points[:, :2] for lane in town.lanes.values()])
        self._left, low = (points.min(axis=0) - MARGIN).tolist()
        right, self._top = (points.max(axis=0) + MARGIN).tolist()
        self._scale = scale
        size = (math.ceil((right - self._left) * scale), math.ceil((self._top - low) * scale))
        self._picture = Image.new("L", size)
        self._draw(town)

    def window(self, ego: EgoState, size: int, below: int) -> UInt8[np.ndarray, "size size"]:
        """Return the pixel codes around the ego, which faces the top row.

        Args:
            ego: The ego.
            size: Pixels along each side.
            below: Pixels from the ego's centre to the lower edge.
        """
        cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
        u = (ego.x - self._left) * self._scale + cos * (size - below) - sin * 0.5 * size
        v = (self._top - ego.y) * self._scale - sin * (size - below) - cos * 0.5 * size
        affine = (sin, -cos, u, cos, sin, v)
        cut = self._picture.transform((size, size), Image.Transform.AFFINE, affine)
        return np.asarray(cut)

    def _draw(self, town: Town) -> None:
        draw = ImageDraw.Draw(self._picture)
        for junction in town.junctions.values():
            if len(junction.outline) > 2:
                draw.polygon(self._pixels(np.array(junction.outline)), fill=ROAD)
        for lane in town.lanes.values():
            width = max(round(lane.width * self._scale), 1)
            draw.line(self._pixels(lane.points[:, :2]), fill=ROAD, width=width, joint="curve")
        thin = max(round(LINE_WIDTH * self._scale), 1)
        for code in (BROKEN, SOLID):
            for lane in town.lanes.values():
                for side in _sides(lane, code):
                    edge = _beside(lane.points[:, :2], side * 0.5 * lane.width)
                    draw.line(self._pixels(edge), fill=ROAD | code, width=thin, joint="curve")

    def _pixels(self, points: Float[np.ndarray, "points 2"]) -> list[tuple[float, float]]:
        """Convert world points to Pillow coordinates: (0, 0) is the first pixel's centre."""
        u = (points[:, 0] - self._left) * self._scale - 0.5
        v = (self._top - points[:, 1]) * self._scale - 0.5
        return list(zip(u.tolist(), v.tolist(), strict=True))


@lru_cache(maxsize=8)
def road_map(town: Town, scale: float) -> RoadMap:
    """Return a town's road map, drawn once."""
    return RoadMap(town, scale)


def _sides(lane: Lane, code: int) -> list[float]:
    """Return the sides with lines of a code: 1.0 left, -1.0 right; none inside junctions."""
    if lane.junction is not None or len(lane.points) < 2:
        return []
    neighbours = {1.0: lane.left, -1.0: lane.right}
    broken = code == BROKEN
    return [side for side, other in neighbours.items() if (other is not None) == broken]


def _beside(points: Float[np.ndarray, "points 2"], offset: float) -> Float[np.ndarray, "points 2"]:
    """Return a polyline shifted sideways by `offset` metres, positive to the left."""
    ahead = np.gradient(points, axis=0)
    ahead /= np.maximum(np.hypot(ahead[:, 0], ahead[:, 1]), 1e-9)[:, None]
    return points + offset * np.stack((-ahead[:, 1], ahead[:, 0]), axis=1)
