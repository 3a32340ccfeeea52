"""Builders of routes, actors, scenes and observations for tests; each needs only what matters.

Straight routes begin at the origin and lead east unless stated otherwise. Actors are stationary
cars unless stated otherwise. SI units and radians, as in the package.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cache

import numpy as np

from plant_bench.agent import (
    PATH_POSES,
    PATH_STEP,
    ROUTE_AHEAD,
    NextLight,
    Observation,
    Privileged,
    RouteAhead,
)
from plant_bench.world.hazard import Hazard
from plant_bench.world.route import LaneSpan, Passage, Route, load_suite
from plant_bench.world.scene import ActorKind, Actors, EgoState, Light, Scene
from plant_bench.world.town import Lane, load_town

CAR_EXTENT = (4.5, 1.8)  # length and width, m
Values = float | Sequence[float] | np.ndarray  # one value for all, or one for each


def straight_route(
    length: int = 200,
    *,
    name: str = "straight",
    town: str = "none",
    lane: str = "e_0",
    start: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    speed_limit: float = 10.0,
    passages: Sequence[Passage] = (),
    hazards: Sequence[Hazard] = (),
    manoeuvres: Mapping[str, int] | None = None,
) -> Route:
    """Build a straight route on one lane, with a point every metre.

    Args:
        length: Metres.
        name: The route's id.
        town: The town's name; there need not be such a town unless the test loads it.
        lane: Id of the lane, "EDGE_INDEX"; `first_lane` finds one of a real town.
        start: First point.
        heading: Direction of the whole route.
        speed_limit: Of all points.
        passages: Junctions on the way.
        hazards: Hazards on the way.
        manoeuvres: Counts of manoeuvres; none without it.
    """
    points = _line(length + 1, start, heading)
    return Route(
        id=name,
        town=town,
        points=points,
        elevations=np.zeros(length + 1),
        speed_limits=np.full(length + 1, speed_limit),
        edges=(lane.rpartition("_")[0],),
        lanes=(LaneSpan(lane, 0.0, float(length)),),
        passages=tuple(passages),
        lane_changes=(),
        manoeuvres=dict(manoeuvres or {}),
        hazards=tuple(hazards),
    )


def first_lane(town: str) -> str:
    """Return the id of a town's first lane: a route on it passes the check against the town."""
    return next(iter(load_town(town).edges.values()))[0].id


@cache
def suite_route(name: str, suite: str = "longest6") -> Route:
    """Return the route of a suite that has this id."""
    return next(route for route in load_suite(suite) if route.id == name)


def straight_route_ahead(
    length: int = ROUTE_AHEAD,
    *,
    start: tuple[float, float] = (0.0, 0.0),
    heading: float = 0.0,
    speed_limits: Values = 10.0,
    progress: float = 0.0,
    past: float = 0.0,
    offset: float = 0.0,
) -> RouteAhead:
    """Build the part of a straight route that lies ahead, as an observation holds it.

    Args:
        length: Metres; there is one point more.
        start: First point.
        heading: Direction.
        speed_limits: At each point.
        progress: Arc length already driven.
        past: How far the ego is beyond the first point.
        offset: How far the ego is to the left of the route.
    """
    return RouteAhead(
        progress,
        past,
        offset,
        _line(length + 1, start, heading),
        np.full(length + 1, heading),
        _each(speed_limits, length + 1),
    )


def route_ahead(route: Route, progress: float) -> RouteAhead:
    """Return what an observation holds of a route when the ego is on it, so many metres along."""
    first = int(np.searchsorted(route.along, progress, side="right")) - 1
    part = slice(first, first + ROUTE_AHEAD + 1)
    return RouteAhead(
        progress,
        progress - float(route.along[first]),
        0.0,
        route.points[part],
        route.headings[part],
        route.speed_limits[part],
    )


def make_actors(
    poses: Iterable[Sequence[float] | np.ndarray] = (),
    *,
    speeds: Values = 0.0,
    extents: Sequence[float] | Sequence[Sequence[float]] | np.ndarray = CAR_EXTENT,
    kinds: int | Sequence[int] | np.ndarray = ActorKind.CAR,
    ids: Iterable[int] | None = None,
) -> Actors:
    """Build actors; all but the poses may be one value for all or one value for each.

    Args:
        poses: x, y and yaw of each; the yaw is 0 where it is left out.
        speeds: m/s.
        extents: Length and width.
        kinds: What they are, values of `ActorKind`.
        ids: Their ids; 0, 1, 2, ... without it.
    """
    placed = np.array([(*pose, 0.0)[:3] for pose in poses], np.float32).reshape(-1, 3)
    count = len(placed)
    return Actors(
        np.arange(count) if ids is None else np.array(list(ids), np.int64),
        placed,
        _each(speeds, count).astype(np.float32),
        np.broadcast_to(np.array(extents, np.float32).reshape(-1, 2), (count, 2)).copy(),
        np.broadcast_to(np.array(kinds, np.uint8), (count,)).copy(),
    )


def cars(*rows: tuple[float, float, float, float], ids: Iterable[int] | None = None) -> Actors:
    """Build cars, each of its x, y, yaw and speed; their ids are 1, 2, 3, ... unless given."""
    return make_actors(
        [row[:3] for row in rows],
        speeds=[row[3] for row in rows],
        ids=range(1, len(rows) + 1) if ids is None else ids,
    )


def straight_lane_facts(
    actors: Actors,
    *,
    accelerations: Values = 0.0,
    desired_speeds: Values = 10.0,
    stop_distances: Values = math.inf,
) -> Privileged:
    """Build the privileged facts on actors whose lanes lead straight on from their poses.

    Args:
        actors: Whom the facts are on.
        accelerations: m/s2.
        desired_speeds: m/s.
        stop_distances: Metres until each must stop; infinite where it need not.
    """
    count = len(actors)
    along = PATH_STEP * np.arange(PATH_POSES)
    yaws = actors.poses[:, 2, None].astype(float)
    x = actors.poses[:, 0, None] + along * np.cos(yaws)
    y = actors.poses[:, 1, None] + along * np.sin(yaws)
    return Privileged(
        np.stack((x, y, np.broadcast_to(yaws, x.shape)), axis=2),
        _each(accelerations, count),
        _each(desired_speeds, count),
        _each(stop_distances, count),
        np.zeros(count),
    )


def make_ego(
    speed: float = 0.0,
    *,
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    acceleration: float = 0.0,
    steering: float = 0.0,
) -> EgoState:
    """Build an ego state: at the origin and heading east unless stated otherwise."""
    return EgoState(x, y, yaw, speed, acceleration, steering)


def make_scene(
    tick: int = 0,
    *,
    ego: EgoState | None = None,
    actors: Actors | None = None,
    lights: Sequence[Light | int] | np.ndarray = (),
) -> Scene:
    """Build a scene: without actors and signals, the ego at rest, unless stated otherwise."""
    return Scene(
        tick,
        make_ego() if ego is None else ego,
        Actors.none() if actors is None else actors,
        np.array(lights, np.uint8),
    )


def make_observation(
    *,
    time: float = 0.0,
    ego: EgoState | None = None,
    speed_limit: float = 10.0,
    actors: Actors | None = None,
    route: RouteAhead | None = None,
    light: NextLight | None = None,
    privileged: Privileged | None = None,
) -> Observation:
    """Build an observation; as for a planner, what is not given is None."""
    ego = make_ego() if ego is None else ego
    return Observation(time, ego, speed_limit, actors, route, light, privileged)


def observation_on(
    route: Route,
    progress: float,
    *,
    speed: float,
    time: float = 0.0,
    actors: Actors | None = None,
    light: NextLight | None = None,
    privileged: Privileged | None = None,
) -> Observation:
    """Build the observation of an ego that is on a route, so many metres along it.

    Args:
        route: It gives the ego's pose, the speed limit and the route ahead.
        progress: Metres along the route.
        speed: The ego's speed.
        time: As of `Observation`, and so are all others.
        actors: Others in sight.
        light: The next traffic light.
        privileged: Facts on the actors.
    """
    x, y = (float(np.interp(progress, route.along, column)) for column in route.points.T)
    yaw = float(np.interp(progress, route.along, route.headings))
    ahead = route_ahead(route, progress)
    return make_observation(
        time=time,
        ego=make_ego(speed, x=x, y=y, yaw=yaw),
        speed_limit=float(ahead.speed_limits[0]),
        actors=actors,
        route=ahead,
        light=light,
        privileged=privileged,
    )


def make_lane(
    name: str,
    points: Sequence[Sequence[float]] | np.ndarray,
    *,
    width: float = 3.5,
    speed_limit: float = 13.9,
    junction: str | None = None,
    successors: Sequence[str] = (),
    left: str | None = None,
    right: str | None = None,
    acceleration: bool = False,
) -> Lane:
    """Build a lane of a town; its edge and index are those of its id.

    Args:
        name: "EDGE_INDEX", as SUMO's ids.
        points: x, y and height of the centre line; the height is 0 where it is left out.
        width: Metres.
        speed_limit: m/s.
        junction: As of `Lane`, and so are all others.
        successors: Lanes that continue it.
        left: The lane to the left of it.
        right: The lane to the right of it.
        acceleration: Whether it is an acceleration lane.
    """
    edge, _, index = name.rpartition("_")
    return Lane(
        id=name,
        edge=edge,
        index=int(index),
        points=np.array([(*point, 0.0)[:3] for point in points], dtype=float),
        width=width,
        speed_limit=speed_limit,
        junction=junction,
        successors=tuple(successors),
        left=left,
        right=right,
        acceleration=acceleration,
    )


def _line(count: int, start: tuple[float, float], heading: float) -> np.ndarray:
    """Return points a metre apart, rounded to millimetres as in files of routes."""
    forward = np.array([math.cos(heading), math.sin(heading)])
    return np.round(np.array(start) + np.arange(float(count))[:, None] * forward, 3)


def _each(values: Values, count: int) -> np.ndarray:
    """Return one value for each of so many."""
    return np.broadcast_to(np.array(values, float), (count,)).copy()
