"""What an agent is given of a scene: what it declared, and nothing else."""

from bisect import bisect_right

import numpy as np

from plant_bench.agent import (
    LIGHT_RANGE,
    ROUTE_AHEAD,
    Input,
    NextLight,
    Observation,
    Privileged,
    RouteAhead,
)
from plant_bench.world.route import Route
from plant_bench.world.scene import EGO_LENGTH, Light, Scene


def observe(
    scene: Scene,
    route: Route,
    progress: float,
    offset: float,
    inputs: frozenset[Input],
    privileged: Privileged | None,
) -> Observation:
    """Return the observation of a scene.

    Args:
        scene: What there is.
        route: The route being driven.
        progress: Arc length the ego has driven of it.
        offset: The ego's lateral distance from it.
        inputs: What the agent declared.
        privileged: The simulator's facts on the scene's actors; handed on if declared.
    """
    last = len(route.points) - 2
    index = min(max(int(np.searchsorted(route.along, progress, side="right")) - 1, 0), last)
    return Observation(
        time=scene.time,
        ego=scene.ego,
        speed_limit=float(route.speed_limits[index]),
        actors=scene.actors if Input.OBJECTS in inputs else None,
        route=_ahead(route, index, progress, offset) if Input.ROUTE in inputs else None,
        light=_next_light(scene, route, progress) if Input.LIGHT in inputs else None,
        privileged=privileged if Input.PRIVILEGED in inputs else None,
    )


def _ahead(route: Route, index: int, progress: float, offset: float) -> RouteAhead:
    part = slice(index, index + ROUTE_AHEAD + 1)
    return RouteAhead(
        progress=progress,
        past=progress - float(route.along[index]),
        offset=offset,
        points=route.points[part],
        headings=route.headings[part],
        speed_limits=route.speed_limits[part],
    )


def _next_light(scene: Scene, route: Route, progress: float) -> NextLight | None:
    front = progress + 0.5 * EGO_LENGTH
    index = bisect_right(route.signal_entries, front - EGO_LENGTH)
    for place in range(index, len(route.signal_entries)):
        distance = route.signal_entries[place] - front
        if distance > LIGHT_RANGE:
            return None
        if scene.lights[place] != Light.UNKNOWN:
            return NextLight(Light(int(scene.lights[place])), distance)
    return None
