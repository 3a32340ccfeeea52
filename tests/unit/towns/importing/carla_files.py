"""Routes of plant-bench in the format of CARLA's leaderboard."""

from collections.abc import Iterable

import numpy as np

from plant_bench.world.route import Route


def as_carla(routes: Iterable[Route], *, version: int = 1) -> str:
    """Return a route file: points 40 to 100 m apart on lane centres, left-handed, in degrees."""
    rng = np.random.default_rng(0)
    texts = [_route(number, route, rng, version) for number, route in enumerate(routes)]
    return "<?xml version='1.0'?>\n<routes>\n" + "\n".join(texts) + "\n</routes>\n"


def _route(number: int, route: Route, rng: np.random.Generator, version: int) -> str:
    points = []
    at = 0.0
    while at < route.length:
        if not any(c.start - 1 <= at <= c.end + 1 for c in route.lane_changes):
            points.append(_point(route, int(np.searchsorted(route.along, at)), version))
        at += rng.uniform(40.0, 100.0)
    points.append(_point(route, len(route.points) - 1, version))
    head = f'<route id="{number}" town="Town{route.town[-2:]}">'
    inside = "".join(points)
    if version == 2:
        inside = f"<weathers/><waypoints>{inside}</waypoints><scenarios/>"
    return f"{head}{inside}</route>"


def _point(route: Route, index: int, version: int) -> str:
    x, y = route.points[index]
    place = f'x="{x:.2f}" y="{-y:.2f}" z="{route.elevations[index]:.2f}"'
    if version == 2:
        return f"<position {place}/>"
    yaw = -np.degrees(route.headings[index])
    return f'<waypoint pitch="0.0" roll="0.0" yaw="{yaw:.2f}" {place}/>'
