"""A scene: everything visible at one instant, for the referee, recordings and agents."""

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
    """Kind of an actor."""

    CAR = 0
    VAN = 1
    TRUCK = 2
    BUS = 3
    MOTORCYCLE = 4
    BICYCLE = 5
    PEDESTRIAN = 6
    STATIC = 7


class Light(IntEnum):
    """State of a traffic light; UNKNOWN if none is in view."""

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
    """Convert array fields of a frozen dataclass to the given types, in `__post_init__`.

    Args:
        value: Instance of the dataclass.
        types: Names of fields with their array types.
    """
    for name, dtype in types:
        if (array := getattr(value, name)).dtype != dtype:
            object.__setattr__(value, name, array.astype(dtype))


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

    float32, so that recordings contain exactly what the referee got; other types are converted.

    Attributes:
        ids: Actor ids, constant over an actor's lifetime.
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
        """Convert arrays to the types that compiled planners expect."""
        if not (
            self.poses.dtype is self.speeds.dtype is self.extents.dtype is _SINGLE
            and self.ids.dtype is _NUMBER
            and self.kinds.dtype is _BYTE
        ):  # fast path: the simulation's arrays always are
            convert_arrays(self, _TYPES)

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def parked(self) -> Bool[np.ndarray, " actors"]:
        """Mask of the parked cars."""
        return self.ids >= PARKED.start

    @property
    def in_traffic(self) -> Bool[np.ndarray, " actors"]:
        """Mask of the actors of SUMO's traffic and of hazards."""
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
        actors: All other actors in sight.
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
