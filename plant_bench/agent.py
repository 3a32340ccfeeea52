"""The planner interface: inputs, observations and actions. The only file a planner's author needs.

A planner is any object with `inputs`, `reset` and `act`; no base class is needed. It declares its
inputs, gets only these, and returns a `Plan` or a `Control` at each tick.

    class Straight:
        inputs = frozenset({Input.ROUTE})

        def reset(self, route): ...

        def act(self, observation):
            return Control(acceleration=1.0, steering=0.0)

`act` is called 20 times a simulated second. A planner with an attribute `interval` is called again
after that many ticks, and its control is held in between (TransFuser and PlanT with perception
decide at 10 Hz: interval 2). The attribute is read after each decision, so it may change.

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
MOST_INTERVAL = 20  # ticks between two decisions, at most: one second
NO_ACTOR = -1  # instead of an actor's id: no actor
LIGHT_RANGE = 50.0  # m: lights farther ahead are not in view


class Input(StrEnum):
    """The built-in inputs that a planner may declare; `plant_bench.sensing.inputs` describes each.

    SIMULATOR is no observation: SUMO's own driver model drives the ego, and actions are ignored.
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
    """The route ahead of the ego, in the world frame.

    Attributes:
        progress: Arc length already driven, metres.
        past: Distance driven past the first of `points`, metres.
        offset: The ego's lateral distance from the route, metres, positive to the left.
        points: One point per metre, from the last one passed; fewer near the end.
        headings: Heading at each point, radians.
        speed_limits: Speed limit at each point, m/s, as `Observation.speed_limit`.
    """

    progress: float
    past: float
    offset: float
    points: Float[np.ndarray, "steps 2"]
    headings: Float[np.ndarray, " steps"]
    speed_limits: Float[np.ndarray, " steps"]

    def __post_init__(self) -> None:
        """Convert all arrays to float64, the type that compiled planners expect."""
        convert_arrays(self, _ROUTE_TYPES)


@dataclass(frozen=True, slots=True)
class NextLight:
    """The next traffic light on the route within `LIGHT_RANGE`.

    Attributes:
        state: Its colour.
        distance: Distance along the route from the ego's front bumper to the stop line, metres;
            negative for up to a car's length after the front has crossed the line.
    """

    state: Light
    distance: float


@dataclass(frozen=True, eq=False, slots=True)
class Privileged:
    """Simulator-only facts about the actors, in their order (PlanT, section 4: the expert).

    Attributes:
        paths: Poses of the box centre along each actor's true lanes, every `PATH_STEP` metres.
        accelerations: Accelerations, m/s2.
        desired_speeds: The lane's speed limit times the driver's speed factor, m/s.
        stop_distances: Path length until the front must stop for a red light or for vehicles with
            right of way, metres; infinite if it need not stop.
        stopped_for: Time since the actor stopped, seconds.
    """

    paths: Float[np.ndarray, "actors steps 3"]
    accelerations: Float[np.ndarray, " actors"]
    desired_speeds: Float[np.ndarray, " actors"]
    stop_distances: Float[np.ndarray, " actors"]
    stopped_for: Float[np.ndarray, " actors"]

    def __post_init__(self) -> None:
        """Convert all arrays to float64, the type that compiled planners expect."""
        convert_arrays(self, _FACT_TYPES)

    def only(self, keep: np.ndarray) -> "Privileged":
        """Return the facts about the actors that a mask or an index array selects."""
        return Privileged(
            self.paths[keep],
            self.accelerations[keep],
            self.desired_speeds[keep],
            self.stop_distances[keep],
            self.stopped_for[keep],
        )


@dataclass(frozen=True, eq=False, slots=True)
class Observation:
    """A planner's input at one tick; fields of inputs that it did not declare are None.

    Attributes:
        time: Seconds since the start of the episode.
        ego: The ego vehicle.
        speed_limit: Speed limit at the ego's position, m/s: the posted one, or what the lane's
            curvature allows.
        actors: Other road users in sight (`Input.OBJECTS`).
        route: The route ahead (`Input.ROUTE`).
        light: The next traffic light; None also if none is in range (`Input.LIGHT`).
        privileged: Simulator-only facts about `actors` (`Input.PRIVILEGED`).
        sensors: Images, point clouds and other arrays by the name of the declared input
            (`plant_bench.sensing.inputs` lists them with their shapes).
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
        """Return the observation with only the actors that a mask or an index array selects."""
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
    """Requested acceleration and steering; the vehicle's own limits apply.

    Attributes:
        acceleration: m/s2, negative to brake.
        steering: Front wheel angle, radians, positive to the left.
    """

    acceleration: float
    steering: float


@runtime_checkable
class Agent(Protocol):
    """A planner."""

    @property
    def inputs(self) -> frozenset[str]:
        """The inputs that it declares: `Input` values, or other names in the table of inputs."""
        ...

    def reset(self, route: Route | None) -> None:
        """Start a new episode; clear all state of the last one.

        Args:
            route: The route to drive, as from a navigation system; None without `Input.ROUTE`.
        """
        ...

    def act(self, observation: Observation) -> Plan | Control:
        """Return an action; called every tick, or every `interval` ticks."""
        ...


@runtime_checkable
class Ranker(Protocol):
    """A planner that can rank the actors by their relevance to its decision."""

    def rank(self, observation: Observation) -> Float[np.ndarray, " actors"]:
        """Return each actor's relevance; higher is more relevant (PlanT, section 4.2)."""
        ...


class Cause(IntEnum):
    """What limits a planner's speed; recordings store these numbers."""

    FREE = 0  # nothing
    LIMIT = 1  # a speed limit or a curve
    LIGHT = 2  # a traffic light
    LEADER = 3  # a vehicle ahead, moving or stationary
    CONFLICT = 4  # an actor predicted to cross the ego's path
    JUNCTION = 5  # a vehicle that blocks the exit of a junction


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a planner chose its last acceleration.

    Attributes:
        cause: The kind of constraint.
        actor: The id of the actor it brakes for; `NO_ACTOR` if the cause is no actor.
    """

    cause: Cause
    actor: int = NO_ACTOR


@runtime_checkable
class Explains(Protocol):
    """A planner that can explain its braking; recordings store the reasons."""

    def explain(self) -> Reason | None:
        """Return the reason for the last action; None if there is no explanation."""
        ...
