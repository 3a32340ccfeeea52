"""The contract between the benchmark and a planner: the only file a planner's author must read.

A planner is any object with `inputs`, `reset` and `act`; no base class is needed. It declares what
it wants to see, is given that and nothing else, and answers each tick with a `Plan` or a `Control`.

    class Straight:
        inputs = frozenset({Input.ROUTE})

        def reset(self, route): ...

        def act(self, observation):
            return Control(acceleration=1.0, steering=0.0)

`act` is called 20 times a simulated second. A planner with an attribute `interval` is called again
after that many ticks, and its control is held in between (TransFuser and PlanT with perception
decide at 10 Hz: interval 2). It is read after each decision, so that it may change.

All values are in SI units and radians; the world frame is x east, y north, yaw counter-clockwise
from +x; the ego frame is x forward, y left, at the centre of the ego's box.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum, StrEnum
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from plant_bench.world.route import Route
from plant_bench.world.scene import Actors, EgoState, Light, convert_arrays

PLAN_STEPS = 4  # waypoints (PlanT, section 3: W = 4)
PLAN_INTERVAL = 0.5  # s between waypoints (PlanT, section 3; data at 2 Hz)
ROUTE_AHEAD = 100  # route points in an observation, one a metre
PATH_STEP = 1.0  # m between the poses of a privileged path
PATH_POSES = 121  # poses of a privileged path, the first at the actor's centre
MOST_INTERVAL = 20  # ticks between two decisions: one second
NOBODY = -1  # in place of an actor's id
LIGHT_RANGE = 50.0  # m: lights farther ahead are not in view


class Input(StrEnum):
    """What a planner may ask to be given; `plant_bench.sensing.inputs` says more of each.

    SIMULATOR is no observation: it hands the ego to SUMO's own driver, and actions go unheard.
    """

    OBJECTS = "objects"
    ROUTE = "route"
    LIGHT = "light"
    PRIVILEGED = "privileged"
    SIMULATOR = "simulator"


_REAL = np.dtype(np.float64)
_ROUTE_TYPES = (("points", _REAL), ("headings", _REAL), ("speed_limits", _REAL))
_FACTS = ("paths", "accelerations", "desired_speeds", "stop_distances", "stopped_for")
_FACT_TYPES = tuple((name, _REAL) for name in _FACTS)


@dataclass(frozen=True, eq=False, slots=True)
class RouteAhead:
    """The route from the ego's place on it, in the world frame.

    Attributes:
        progress: Arc length already driven, metres.
        past: Of it, since the first of `points`: the ego is so far beyond that point.
        offset: The ego's lateral distance from the route, positive to the left of it.
        points: One a metre, the first the last point passed; fewer near the end.
        headings: Radians at each point.
        speed_limits: m/s at each point, as `Observation.speed_limit`.
    """

    progress: float
    past: float
    offset: float
    points: Float[np.ndarray, "steps 2"]
    headings: Float[np.ndarray, " steps"]
    speed_limits: Float[np.ndarray, " steps"]

    def __post_init__(self) -> None:
        """Let all arrays be of float64, which compiled planners take."""
        convert_arrays(self, _ROUTE_TYPES)


@dataclass(frozen=True, slots=True)
class NextLight:
    """The next traffic light on the route within `LIGHT_RANGE`.

    Attributes:
        state: What it shows.
        distance: From the ego's front bumper to the stop line along the route, metres; negative
            for up to a car's length after the front has crossed it.
    """

    state: Light
    distance: float


@dataclass(frozen=True, eq=False, slots=True)
class Privileged:
    """What only the simulator knows of the actors, in their order (PlanT, section 4: the expert).

    Attributes:
        paths: Poses of the box centre along each actor's true lanes, every `PATH_STEP` metres.
        accelerations: m/s2.
        desired_speeds: m/s, the lane's limit times the driver's factor.
        stop_distances: Metres of path until the front must stop for a red light or for others with
            the right of way; infinite where it may go on.
        stopped_for: Seconds it has been standing.
    """

    paths: Float[np.ndarray, "actors steps 3"]
    accelerations: Float[np.ndarray, " actors"]
    desired_speeds: Float[np.ndarray, " actors"]
    stop_distances: Float[np.ndarray, " actors"]
    stopped_for: Float[np.ndarray, " actors"]

    def __post_init__(self) -> None:
        """Let all arrays be of float64, which compiled planners take."""
        convert_arrays(self, _FACT_TYPES)

    def only(self, keep: np.ndarray) -> "Privileged":
        """Return the facts of the actors that a mask or an index array selects."""
        return Privileged(
            self.paths[keep],
            self.accelerations[keep],
            self.desired_speeds[keep],
            self.stop_distances[keep],
            self.stopped_for[keep],
        )


@dataclass(frozen=True, eq=False, slots=True)
class Observation:
    """What a planner is given at one tick; fields it did not declare are None.

    Attributes:
        time: Seconds since the start of the episode.
        ego: The ego vehicle.
        speed_limit: At the ego's place, m/s: the posted one, or what the lane's curvature allows.
        actors: Others in sight (`Input.OBJECTS`).
        route: The route ahead (`Input.ROUTE`).
        light: The next traffic light, None also where none is in view (`Input.LIGHT`).
        privileged: The simulator's facts on `actors` (`Input.PRIVILEGED`).
        sensors: Images, point clouds and the like, by the name of the input that was declared
            (`plant_bench.sensing.inputs` says which there are, and their shapes).
    """

    time: float
    ego: EgoState
    speed_limit: float
    actors: Actors | None = None
    route: RouteAhead | None = None
    light: NextLight | None = None
    privileged: Privileged | None = None
    sensors: Mapping[str, np.ndarray] = field(default_factory=dict)

    def showing(self, keep: np.ndarray) -> "Observation":
        """Return the observation with the actors alone that a mask or an index array selects."""
        actors, facts = self.actors, self.privileged
        return replace(
            self,
            actors=None if actors is None else actors.only(keep),
            privileged=None if facts is None else facts.only(keep),
        )


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """Waypoints in the ego frame at 0.5, 1.0, 1.5 and 2.0 s, driven by `follow_plan`.

    Attributes:
        waypoints: x forward, y left, metres.
    """

    waypoints: Float[np.ndarray, "waypoints 2"]


@dataclass(frozen=True, slots=True)
class Control:
    """What the ego's actuators are asked for; limits are the vehicle's own.

    Attributes:
        acceleration: m/s2, negative to brake.
        steering: Front wheel angle in radians, positive to the left.
    """

    acceleration: float
    steering: float


@runtime_checkable
class Agent(Protocol):
    """A planner."""

    @property
    def inputs(self) -> frozenset[str]:
        """What it asks to be given: names of `Input`, or others of the table of inputs."""
        ...

    def reset(self, route: Route | None) -> None:
        """Start a new episode and forget the last one.

        Args:
            route: The global plan, as a navigation system has it; None without `Input.ROUTE`.
        """
        ...

    def act(self, observation: Observation) -> Plan | Control:
        """Decide; called every tick, or every `interval` ticks."""
        ...


@runtime_checkable
class Ranker(Protocol):
    """A planner that can tell which actors matter to it."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return the relevance of each actor, the higher the more relevant (PlanT, section 4.2)."""
        ...


class Cause(IntEnum):
    """Why a planner drives no faster; recordings hold these numbers."""

    FREE = 0  # nothing keeps it
    LIMIT = 1  # it slows down for a speed limit or a curve
    LIGHT = 2  # a traffic light
    LEADER = 3  # whom it follows, or who stands in its way
    CONFLICT = 4  # who would cross its path
    JUNCTION = 5  # who leaves it no room beyond a junction


@dataclass(frozen=True, slots=True)
class Reason:
    """The one thing that decided a planner's acceleration.

    Attributes:
        cause: What kind of thing.
        actor: The id of the one actor it brakes for; `NOBODY` where the cause is no actor.
    """

    cause: Cause
    actor: int = NOBODY


@runtime_checkable
class Explains(Protocol):
    """A planner that can tell why it brakes; recordings keep what it says."""

    def explain(self) -> Reason | None:
        """Return the reason of the last action; None where it cannot tell."""
        ...
