"""Decides which links a long vehicle may use without leaving its lane in curves.

SUMO models a vehicle as a rigid box whose front and rear are both on its lane, so its sides cut a
curve by about length^2 / (8 radius). Real drivers do not steer like that; a long vehicle does not
use links on which it would come too near to adjacent lanes.
"""

import numpy as np
from jaxtyping import Float

from plant_bench.geometry.polyline import arc_lengths
from plant_bench.world.conflicting_paths import joined_line
from plant_bench.world.town import Link, Town

MARGIN = 0.4  # m beyond its lane's side; an ego centred on a 3.5 m lane is 0.28 m from it
FREE_LENGTH = 6.0  # m: shorter vehicles may use all links
_SPACING = 1.0  # m between the checked positions of the box
_ALONG = np.linspace(0.125, 0.875, 7)  # checked points of the box, as shares of its length


def reach_aside(points: Float[np.ndarray, "points 2"], length: float, width: float) -> float:
    """Return the largest lateral reach of a box that drives along a line, metres.

    Args:
        points: The line, without repeated points.
        length: Length of the box, metres; its rear is this far behind its front on the line.
        width: Width of the box, metres.
    """
    along = arc_lengths(points)
    front = np.arange(min(length, along[-1]), along[-1] + 1e-6, _SPACING)
    x, y = np.interp(front, along, points[:, 0]), np.interp(front, along, points[:, 1])
    rear_x = np.interp(front - length, along, points[:, 0])
    rear_y = np.interp(front - length, along, points[:, 1])
    chord = np.maximum(np.hypot(x - rear_x, y - rear_y), 1e-6)
    across_x, across_y = -(y - rear_y) / chord, (x - rear_x) / chord
    at = front[:, None] - length * _ALONG
    aside = across_x[:, None] * (np.interp(at, along, points[:, 0]) - x[:, None])
    aside += across_y[:, None] * (np.interp(at, along, points[:, 1]) - y[:, None])
    return float(np.abs(aside).max()) + 0.5 * width


def fits(town: Town, link: Link, length: float, width: float) -> bool:
    """Tell whether a vehicle may use a link, with its source and target lane.

    Its box must stay within half the lane's width and `MARGIN` of the lanes' centre line.
    """
    if length < FREE_LENGTH:
        return True
    lanes = [town.lanes[lane] for lane in (link.source, *link.via, link.target)]
    allowed = 0.5 * min(lane.width for lane in lanes) + MARGIN
    return reach_aside(joined_line(lanes), length, width) <= allowed
