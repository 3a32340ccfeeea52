"""A scene: all that can be seen at one instant. The referee, recordings and agents share it."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from plant_bench.world.actor_ids import PARKED, TRAFFIC

TICK = 0.05  # s: 20 Hz, as the CARLA leaderboard
EGO_LENGTH = 4.90  # m, CARLA's lincoln.mkz2017 (PlanT, carla_agent_files/PlanT_agent.py)
EGO_WIDTH = 2.13  # m, as above
EGO_EXTENT = (EGO_LENGTH, EGO_WIDTH)
WHEELBASE = 2.86  # m, CARLA's lincoln.mkz2017


class ActorKind(IntEnum):
    """What an actor is; the score and planners tell kinds apart by this."""

    CAR = 0
    VAN = 1
    TRUCK = 2
    BUS = 3
    MOTORCYCLE = 4
    BICYCLE = 5
    PEDESTRIAN = 6
    STATIC = 7


class Light(IntEnum):
    """What a traffic light shows; UNKNOWN where none is in view."""

    UNKNOWN = 0
    GREEN = 1
    YELLOW = 2
    RED = 3


@dataclass(frozen=True, slots=True)
class EgoState:
    """The ego vehicle: box centre in the world, radians counter-clockwise from +x.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Radians.
        speed: m/s, never negative.
        acceleration: m/s2 along the heading, as driven in the last tick.
        steering: Front wheel angle in radians, positive to the left.
    """

    x: float
    y: float
    yaw: float
    speed: float
    acceleration: float = 0.0
    steering: float = 0.0

    @property
    def pose(self) -> tuple[float, float, float]:
        """(x, y, yaw)."""
        return self.x, self.y, self.yaw


def convert_arrays(value: object, types: tuple[tuple[str, np.dtype], ...]) -> None:
    """Let the arrays of a frozen value that is being made be of some types.

    Args:
        value: Of a dataclass.
        types: Names of fields with what their arrays are to be.
    """
    for name, wanted in types:
        if (array := getattr(value, name)).dtype != wanted:
            object.__setattr__(value, name, array.astype(wanted))


_SINGLE, _NUMBER, _BYTE = np.dtype(np.float32), np.dtype(np.int64), np.dtype(np.uint8)
_TYPES = (
    ("ids", _NUMBER),
    ("poses", _SINGLE),
    ("speeds", _SINGLE),
    ("extents", _SINGLE),
    ("kinds", _BYTE),
)


@dataclass(frozen=True, eq=False, slots=True)
class Actors:
    """Other road users as a struct of arrays, in a fixed order (by id) within a scene.

    float32, so that what a recording holds is what the referee saw, bit for bit; other types are
    converted.

    Attributes:
        ids: Numbers that stay with an actor for its whole life.
        poses: Box centres x, y, yaw.
        speeds: m/s.
        extents: Full length and width, metres.
        kinds: `ActorKind` values.
    """

    ids: Int[np.ndarray, " actors"]
    poses: Float[np.ndarray, "actors 3"]
    speeds: Float[np.ndarray, " actors"]
    extents: Float[np.ndarray, "actors 2"]
    kinds: UInt8[np.ndarray, " actors"]

    def __post_init__(self) -> None:
        """Let all arrays be of the types that compiled planners take."""
        if not (
            self.poses.dtype is self.speeds.dtype is self.extents.dtype is _SINGLE
            and self.ids.dtype is _NUMBER
            and self.kinds.dtype is _BYTE
        ):  # the simulation's own always are, several times a tick
            convert_arrays(self, _TYPES)

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def parked(self) -> Bool[np.ndarray, " actors"]:
        """Who is a parked car."""
        return self.ids >= PARKED.start

    @property
    def in_traffic(self) -> Bool[np.ndarray, " actors"]:
        """Who takes part in SUMO's traffic, or was put out by a hazard."""
        return self.ids < TRAFFIC.stop

    def only(self, keep: np.ndarray) -> "Actors":
        """Return the actors that a boolean mask or an index array selects."""
        return Actors(
            self.ids[keep],
            self.poses[keep],
            self.speeds[keep],
            self.extents[keep],
            self.kinds[keep],
        )

    @classmethod
    def none(cls) -> "Actors":
        """Return an empty set of actors."""
        return cls(
            np.zeros(0, np.int64),
            np.zeros((0, 3), np.float32),
            np.zeros(0, np.float32),
            np.zeros((0, 2), np.float32),
            np.zeros(0, np.uint8),
        )


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """One instant of an episode.

    Attributes:
        tick: 0 at the start of the episode.
        ego: The ego vehicle.
        actors: All others in sight.
        lights: `Light` values of the signals on the ego's route, in the order of
            `Route.signal_passages`; UNKNOWN for those out of view.
    """

    tick: int
    ego: EgoState
    actors: Actors
    lights: UInt8[np.ndarray, " signals"]

    @property
    def time(self) -> float:
        """Seconds since the start of the episode."""
        return self.tick * TICK
