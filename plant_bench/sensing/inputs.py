"""The table of planner inputs: name, description, function, observation field, wire format, track.

A new input is one row here and the function that computes it. Everything else reads the table: the
inputs that a planner may declare, `restrict`, the messages to planners in other processes, and the
track in which a planner is listed.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from types import MappingProxyType
from typing import Any

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
from plant_bench.errors import AgentError
from plant_bench.world.route import Route
from plant_bench.world.scene import EGO_LENGTH, Actors, Light, Scene
from plant_bench.world.town import Town


class Track(IntEnum):
    """A planner's leaderboard track, set by its inputs; higher tracks get more information."""

    SENSORS = 0  # raw sensor data and the navigation route
    OBJECTS = 1  # ground-truth perception: boxes and traffic lights
    PRIVILEGED = 2  # facts that only the simulator has

    @property
    def label(self) -> str:
        """The track's name in tables."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class SensingContext:
    """The data from which an input's function computes its value at one tick.

    Attributes:
        scene: The scene.
        route: The route being driven.
        index: Index of the last route point passed, at most that of the last but one.
        progress: Arc length of the route that the ego has driven, metres.
        offset: The ego's lateral distance from the route, metres, positive to the left.
        facts: Simulator-only facts about the scene's actors; None if no planner here may get them.
        seed: The scenario's seed. Noise must depend on it and `scene.tick` alone, so that episodes
            are reproducible.
    """

    scene: Scene
    route: Route
    index: int
    progress: float
    offset: float
    facts: Privileged | None
    seed: int

    @property
    def town(self) -> Town:
        """The town; loaded from disk once."""
        return self.route.load_town()


@dataclass(frozen=True)
class WireRecord:
    """How a dataclass is sent: a map of numbers and arrays; arrays are sent as float64.

    Attributes:
        type: The dataclass, called with the fields as keywords.
        numbers: The type that converts each received number.
        arrays: The dtype of each received array.
    """

    type: Callable[..., Any]
    numbers: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    arrays: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class InputRow:
    """One input.

    Attributes:
        name: The name that planners declare.
        track: The track that it puts a planner in.
        description: Description with shape, unit and frame.
        make: Computes its value; None if it is no part of an observation.
        field: The field of `Observation`; empty for an array in `Observation.sensors`.
        record: Its wire format; None for an array, which keeps its dtype and shape.
    """

    name: str
    track: Track
    description: str
    make: Callable[[SensingContext], Any] | None = None
    field: str = ""
    record: WireRecord | None = None


def _actors(context: SensingContext) -> Actors:
    return context.scene.actors


def _route_ahead(context: SensingContext) -> RouteAhead:
    route, index = context.route, context.index
    part = slice(index, index + ROUTE_AHEAD + 1)
    return RouteAhead(
        progress=context.progress,
        past=context.progress - float(route.along[index]),
        offset=context.offset,
        points=route.points[part],
        headings=route.headings[part],
        speed_limits=route.speed_limits[part],
    )


def _next_light(context: SensingContext) -> NextLight | None:
    entries, lights = context.route.signal_entries, context.scene.lights
    front = context.progress + 0.5 * EGO_LENGTH
    for place in range(bisect_right(entries, front - EGO_LENGTH), len(entries)):
        distance = entries[place] - front
        if distance > LIGHT_RANGE:
            return None
        if lights[place] != Light.UNKNOWN:
            return NextLight(Light(int(lights[place])), distance)
    return None


def _facts(context: SensingContext) -> Privileged | None:
    return context.facts


_REALS = np.float64
_ROWS = (
    InputRow(
        Input.OBJECTS,
        Track.OBJECTS,
        "boxes of all other road users in sight: ids, poses, speeds, extents, kinds",
        _actors,
        "actors",
        WireRecord(  # dtypes as in `Scene`: a planner computes the same in either process
            Actors,
            arrays={
                "ids": np.int64,
                "poses": np.float32,
                "speeds": np.float32,
                "extents": np.float32,
                "kinds": np.uint8,
            },
        ),
    ),
    InputRow(
        Input.ROUTE,
        Track.SENSORS,
        f"the next {ROUTE_AHEAD} m of the route, one point per metre, with speed limits",
        _route_ahead,
        "route",
        WireRecord(
            RouteAhead,
            {"progress": float, "past": float, "offset": float},
            {"points": _REALS, "headings": _REALS, "speed_limits": _REALS},
        ),
    ),
    InputRow(
        Input.LIGHT,
        Track.OBJECTS,
        f"the next traffic light on the route within {LIGHT_RANGE:.0f} m",
        _next_light,
        "light",
        WireRecord(NextLight, {"state": Light, "distance": float}),
    ),
    InputRow(
        Input.PRIVILEGED,
        Track.PRIVILEGED,
        "simulator-only facts about the actors: future paths, desired speeds, stops",
        _facts,
        "privileged",
        WireRecord(
            Privileged,
            arrays=dict.fromkeys(
                ("paths", "accelerations", "desired_speeds", "stop_distances", "stopped_for"),
                _REALS,
            ),
        ),
    ),
    InputRow(
        Input.SIMULATOR,
        Track.PRIVILEGED,
        "nothing: SUMO's driver model drives, actions are ignored",
    ),
)
INPUTS: Mapping[str, InputRow] = MappingProxyType({row.name: row for row in _ROWS})

PERCEIVED = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})  # ground-truth perception
DRIVER_ONLY = frozenset({Input.PRIVILEGED, Input.SIMULATOR})  # for the driving planner alone


def check_inputs(inputs: Iterable[object], who: str) -> None:
    """Check that all declared inputs exist.

    Args:
        inputs: The declared inputs.
        who: The planner's name in the message.

    Raises:
        AgentError: An input is unknown.
    """
    unknown = sorted({str(item) for item in inputs if item not in INPUTS})
    if unknown:
        message = f"{who} declares unknown inputs {', '.join(unknown)}: choose from {_choices()}."
        raise AgentError(message)


def restrict(observation: Observation, inputs: Iterable[str]) -> Observation:
    """Return an observation without the inputs that a planner has not declared."""
    left = set(inputs)
    hidden = {row.field: None for row in INPUTS.values() if row.field and row.name not in left}
    sensors = {name: value for name, value in observation.sensors.items() if name in left}
    return replace(observation, sensors=sensors, **hidden)


def track_of(inputs: Iterable[str]) -> Track:
    """Return a planner's track: the highest of its inputs' tracks; unknown inputs are privileged.

    >>> track_of(["objects", "route"]).label, track_of(["route"]).label
    ('objects', 'sensors')
    """
    tracks = (INPUTS[name].track if name in INPUTS else Track.PRIVILEGED for name in inputs)
    return max(tracks, default=Track.SENSORS)


def _choices() -> str:
    return ", ".join(INPUTS)
