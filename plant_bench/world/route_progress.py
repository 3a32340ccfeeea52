"""Tracks the ego's progress along its route and its distance from it."""

import math

from plant_bench.geometry.polyline import Cursor
from plant_bench.world.route import Route


class RouteProgress:
    """The ego's position on its route; mutable.

    As in the CARLA leaderboard, only points ahead are searched: an ego that turns back gets farther
    from the route.

    Attributes:
        progress: Arc length on the route, metres; never decreases.
        offset: Lateral distance from the route, positive to the left of it.
        distance: Distance from the part of the route that was reached, never negative.
        index: The route point last passed.
    """

    def __init__(self, route: Route) -> None:
        self._cursor = Cursor(route.points)
        self._x = route.points[:, 0].tolist()
        self._y = route.points[:, 1].tolist()
        self.progress = 0.0
        self.offset = 0.0
        self.distance = 0.0
        self.index = 0

    @property
    def heading(self) -> float:
        """The route's heading at the ego's position."""
        return self._cursor.heading

    def follow(self, x: float, y: float) -> None:
        """Update to the ego's new position."""
        cursor = self._cursor
        cursor.advance(x, y)
        self.progress, self.offset, self.index = cursor.progress, cursor.offset, cursor.index
        i = self.index
        x0, y0, x1, y1 = self._x[i], self._y[i], self._x[i + 1], self._y[i + 1]
        if (x - x0) * (x1 - x0) + (y - y0) * (y1 - y0) < 0.0:
            self.distance = math.hypot(x - x0, y - y0)
        elif (x - x1) * (x1 - x0) + (y - y1) * (y1 - y0) > 0.0:
            self.distance = math.hypot(x - x1, y - y1)
        else:
            self.distance = abs(self.offset)
