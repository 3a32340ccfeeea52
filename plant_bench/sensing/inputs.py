"""The one table of what a planner may be given: who makes it, where it is found, who may see it.

A new input is one row here and the function that makes it. Everything else reads the table: what a
planner may declare, what `given` leaves it, how it travels to planners in other processes, and the
track in which a planner is shown.
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
    """In whose company a planner is shown: the higher, the more it is told."""

    SENSORS = 0  # raw signals and a navigation system's route
    OBJECTS = 1  # boxes, lights: what a perfect perception would tell
    PRIVILEGED = 2  # what only the simulator knows

    @property
    def label(self) -> str:
        """Its name in tables."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Moment:
    """What an input is made of.

    Attributes:
        scene: What there is.
        route: The route being driven.
        index: Of the last route point that the ego has passed; never the very last one.
        progress: Arc length the ego has driven of it, metres.
        offset: The ego's lateral distance from it, metres, positive to the left.
        facts: What only the simulator knows of the scene's actors; None where nobody may have it.
        seed: The scenario's. Noise of a tick is drawn from it and `scene.tick`, nothing else, so
            that an episode repeats.
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
        """The town; read from the disk once."""
        return self.route.load_town()


@dataclass(frozen=True)
class Record:
    """How a dataclass travels: a map of numbers and arrays, the latter as float64.

    Attributes:
        type: Made of them again, by keyword.
        numbers: What makes each number on arrival.
        arrays: The type of each array on arrival.
    """

    type: Callable[..., Any]
    numbers: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    arrays: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class InputRow:
    """One input.

    Attributes:
        name: As planners declare it.
        track: In which it puts a planner.
        about: What it is: shape, unit and frame.
        make: Makes it of a moment; None where it is no part of an observation.
        field: Of `Observation`; empty for an array in `Observation.sensors`.
        record: How it travels; None for an array, which keeps its type and shape.
    """

    name: str
    track: Track
    about: str
    make: Callable[[Moment], Any] | None = None
    field: str = ""
    record: Record | None = None


def _actors(moment: Moment) -> Actors:
    return moment.scene.actors


def _route_ahead(moment: Moment) -> RouteAhead:
    route, index = moment.route, moment.index
    part = slice(index, index + ROUTE_AHEAD + 1)
    return RouteAhead(
        progress=moment.progress,
        past=moment.progress - float(route.along[index]),
        offset=moment.offset,
        points=route.points[part],
        headings=route.headings[part],
        speed_limits=route.speed_limits[part],
    )


def _next_light(moment: Moment) -> NextLight | None:
    entries, lights = moment.route.signal_entries, moment.scene.lights
    front = moment.progress + 0.5 * EGO_LENGTH
    for place in range(bisect_right(entries, front - EGO_LENGTH), len(entries)):
        distance = entries[place] - front
        if distance > LIGHT_RANGE:
            return None
        if lights[place] != Light.UNKNOWN:
            return NextLight(Light(int(lights[place])), distance)
    return None


def _facts(moment: Moment) -> Privileged | None:
    return moment.facts


_REALS = np.float64
_ROWS = (
    InputRow(
        Input.OBJECTS,
        Track.OBJECTS,
        "boxes of all others in sight: ids, poses, speeds, extents, kinds",
        _actors,
        "actors",
        Record(  # arrays as scenes hold them: a planner reckons alike in either process
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
        f"the route for {ROUTE_AHEAD} m ahead, a point a metre, with speed limits",
        _route_ahead,
        "route",
        Record(
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
        Record(NextLight, {"state": Light, "distance": float}),
    ),
    InputRow(
        Input.PRIVILEGED,
        Track.PRIVILEGED,
        "what only the simulator knows of the others: where they will go, and what stops them",
        _facts,
        "privileged",
        Record(
            Privileged,
            arrays=dict.fromkeys(
                ("paths", "accelerations", "desired_speeds", "stop_distances", "stopped_for"),
                _REALS,
            ),
        ),
    ),
    InputRow(
        Input.SIMULATOR, Track.PRIVILEGED, "nothing: SUMO's own driver drives, actions go unheard"
    ),
)
INPUTS: Mapping[str, InputRow] = MappingProxyType({row.name: row for row in _ROWS})

PERCEIVED = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})  # by a perfect perception
UNSHARED = frozenset({Input.PRIVILEGED, Input.SIMULATOR})  # what nobody has who only looks on


def check_inputs(inputs: Iterable[object], who: str) -> None:
    """Check that a planner declares what there is.

    Args:
        inputs: As it declares them.
        who: Names it, for the message.

    Raises:
        AgentError: One is unknown.
    """
    unknown = sorted({str(item) for item in inputs if item not in INPUTS})
    if unknown:
        message = f"{who} declares unknown inputs {', '.join(unknown)}: choose from {_choices()}."
        raise AgentError(message)


def given(observation: Observation, inputs: Iterable[str]) -> Observation:
    """Return an observation as a planner that declares these inputs sees it."""
    left = set(inputs)
    hidden = {row.field: None for row in INPUTS.values() if row.field and row.name not in left}
    sensors = {name: value for name, value in observation.sensors.items() if name in left}
    return replace(observation, sensors=sensors, **hidden)


def track_of(inputs: Iterable[str]) -> Track:
    """Return the track of a planner: that of the input which tells it most; unknown ones tell all.

    >>> track_of(["objects", "route"]).label, track_of(["route"]).label
    ('objects', 'sensors')
    """
    tracks = (INPUTS[name].track if name in INPUTS else Track.PRIVILEGED for name in inputs)
    return max(tracks, default=Track.SENSORS)


def _choices() -> str:
    return ", ".join(INPUTS)
