"""What a planner is told, as messages and back; docs/protocol-agents.md says every field."""

from typing import Any

import numpy as np

from plant_bench.agent import NextLight, Observation, Privileged, RouteAhead
from plant_bench.agents.remote.codec import array_in, array_out
from plant_bench.world.route import LaneChange, LaneSpan, Passage, Route
from plant_bench.world.scene import Actors, EgoState, Light

PROTOCOL_VERSION = 1
_ACTORS = {
    "ids": np.int64,
    "poses": np.float32,
    "speeds": np.float32,
    "extents": np.float32,
    "kinds": np.uint8,
}  # as scenes hold them, so that a planner reckons with the same numbers in either process
_EGO = ("x", "y", "yaw", "speed", "acceleration", "steering")
_PRIVILEGED = ("paths", "accelerations", "desired_speeds", "stop_distances", "stopped_for")
_ROUTE_ARRAYS = ("points", "elevations", "speed_limits")
_AHEAD_NUMBERS = ("progress", "past", "offset")
_AHEAD_ARRAYS = ("points", "headings", "speed_limits")

Wire = dict[str, Any]


def hello_out(agent: str) -> Wire:
    """Return the question for what a planner is; `agent` names it, where a process has several."""
    return {"type": "hello", "protocol": PROTOCOL_VERSION, "agent": agent}


def reset_out(route: Route | None) -> Wire:
    """Return the begin of an episode."""
    return {"type": "reset", "route": None if route is None else route_out(route)}


def observation_out(kind: str, observation: Observation) -> Wire:
    """Return a question about an observation: "act" or "rank"."""
    ahead, light = observation.route, observation.light
    actors, facts = observation.actors, observation.privileged
    return {
        "type": kind,
        "time": observation.time,
        "speed_limit": observation.speed_limit,
        "ego": {name: getattr(observation.ego, name) for name in _EGO},
        "actors": None if actors is None else _arrays_out(actors, _ACTORS),
        "route": None if ahead is None else _numbers_out(ahead) | _arrays_out(ahead, _AHEAD_ARRAYS),
        "light": None if light is None else {"state": int(light.state), "distance": light.distance},
        "privileged": None if facts is None else _arrays_out(facts, _PRIVILEGED),
    }


def observation_in(wire: Wire) -> Observation:
    """Return the observation of a question."""
    actors, ahead, light, facts = (
        wire[name] for name in ("actors", "route", "light", "privileged")
    )
    return Observation(
        time=wire["time"],
        ego=EgoState(**wire["ego"]),
        speed_limit=wire["speed_limit"],
        actors=None if actors is None else _actors_in(actors),
        route=None if ahead is None else _ahead_in(ahead),
        light=None if light is None else NextLight(Light(light["state"]), light["distance"]),
        privileged=None if facts is None else _privileged_in(facts),
    )


def route_out(route: Route) -> Wire:
    """Return a route as it is sent, to the last bit."""
    return {
        "id": route.id,
        "town": route.town,
        "edges": list(route.edges),
        "lanes": [vars(span) for span in route.lanes],
        "passages": [vars(passage) for passage in route.passages],
        "lane_changes": [vars(change) for change in route.lane_changes],
        "manoeuvres": route.manoeuvres,
        **_arrays_out(route, _ROUTE_ARRAYS),
    }


def route_in(wire: Wire) -> Route:
    """Return the route that was sent."""
    return Route(
        id=wire["id"],
        town=wire["town"],
        edges=tuple(wire["edges"]),
        lanes=tuple(LaneSpan(**span) for span in wire["lanes"]),
        passages=tuple(Passage(**passage) for passage in wire["passages"]),
        lane_changes=tuple(LaneChange(**change) for change in wire["lane_changes"]),
        manoeuvres=wire["manoeuvres"],
        **_arrays_in(wire, _ROUTE_ARRAYS),
    )


def _arrays_out(value: object, names: Any) -> Wire:
    return {name: array_out(getattr(value, name)) for name in names}


def _arrays_in(wire: Wire, names: Any) -> dict[str, Any]:
    return {name: array_in(wire[name]) for name in names}


def _numbers_out(ahead: RouteAhead) -> Wire:
    return {name: getattr(ahead, name) for name in _AHEAD_NUMBERS}


def _actors_in(wire: Wire) -> Actors:
    arrays = {name: array_in(wire[name]).astype(kind) for name, kind in _ACTORS.items()}
    for values in arrays.values():
        values.flags.writeable = False  # as those of a scene
    return Actors(**arrays)


def _ahead_in(wire: Wire) -> RouteAhead:
    numbers = {name: wire[name] for name in _AHEAD_NUMBERS}
    return RouteAhead(**numbers, **_arrays_in(wire, _AHEAD_ARRAYS))


def _privileged_in(wire: Wire) -> Privileged:
    return Privileged(**_arrays_in(wire, _PRIVILEGED))
