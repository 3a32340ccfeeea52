"""Collision detection: what counts as a new collision, and which side caused it (CARLA LB 1.0)."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from plant_bench.scoring.infractions import InfractionKind
from plant_bench.world.scene import EGO_EXTENT, TICK, ActorKind, Actors, EgoState, Scene

# CollisionTest of scenario_runner 1.0, atomic_criteria.py.
SAME_PLACE = 3.0  # m: contacts closer to an earlier one do not count (MIN_AREA_OF_COLLISION)
PLACE_RESET = 5.0  # m: ... until the ego is this far from it (MAX_AREA_OF_COLLISION)
ACTOR_RESET = 5.0  # s without contact: then the last actor counts again (MAX_ID_TIME)
STATIONARY = 0.1  # m/s (leaderboard 2.0, CollisionTest: a slower ego does not cause a collision)
FRONT = math.cos(math.radians(45.0))  # own choice: contact normals within 45 degrees are frontal

COLLISION_KINDS = {
    ActorKind.PEDESTRIAN: InfractionKind.COLLISION_PEDESTRIAN,
    ActorKind.STATIC: InfractionKind.COLLISION_STATIC,
}  # every other kind is a vehicle


class Collision(NamedTuple):
    """A collision that counts.

    Attributes:
        kind: Pedestrian, vehicle or static.
        actor: The other actor's id.
        actor_kind: The other actor's kind.
        cause: "other" if the other actor ran into the ego, else "ego".
    """

    kind: InfractionKind
    actor: int
    actor_kind: ActorKind
    cause: str


class CollisionDetector:
    """Detects new collisions, leaving out contacts that were counted already; mutable."""

    def __init__(self) -> None:
        self._last_actor: int | None = None
        self._last_contact = 0
        self._places: list[tuple[float, float]] = []

    def new(self, scene: Scene) -> list[Collision]:
        """Return the collisions that begin in this scene, in the order of the actors."""
        ego, actors = scene.ego, scene.actors
        self._forget(scene.tick, ego)
        return [
            self._collision(scene, index)
            for index in overlapping_actors(ego, actors)
            if self._counts(scene, index)
        ]

    def _forget(self, tick: int, ego: EgoState) -> None:
        if self._places:
            self._places = [
                place
                for place in self._places
                if math.hypot(ego.x - place[0], ego.y - place[1]) <= PLACE_RESET
            ]
        if self._last_actor is not None and (tick - self._last_contact) * TICK > ACTOR_RESET:
            self._last_actor = None

    def _counts(self, scene: Scene, index: int) -> bool:
        """Return whether a contact is a new collision, and remember it."""
        ego, actor = scene.ego, int(scene.actors.ids[index])
        if actor == self._last_actor:
            self._last_contact = scene.tick
            return False
        if any(math.hypot(ego.x - x, ego.y - y) <= SAME_PLACE for x, y in self._places):
            return False
        self._places.append((ego.x, ego.y))
        if scene.actors.kinds[index] != ActorKind.STATIC:
            self._last_actor, self._last_contact = actor, scene.tick
        return True

    @staticmethod
    def _collision(scene: Scene, index: int) -> Collision:
        actors = scene.actors
        kind = ActorKind(int(actors.kinds[index]))
        x, y, yaw = (float(value) for value in actors.poses[index])
        length, width = (float(value) for value in actors.extents[index])
        return Collision(
            COLLISION_KINDS.get(kind, InfractionKind.COLLISION_VEHICLE),
            int(actors.ids[index]),
            kind,
            cause_of(scene.ego, (x, y, yaw), (length, width), float(actors.speeds[index])),
        )


def overlapping_actors(ego: EgoState, actors: Actors) -> list[int]:
    """Return the indices of actors whose boxes overlap the ego's (touching edges do not).

    Plain Python instead of numpy: few actors are near, and this runs at every tick.
    """
    x, y, near = ego.x, ego.y, 0.5 * sum(EGO_EXTENT)
    overlapping = []
    boxes = zip(actors.poses.tolist(), actors.extents.tolist(), strict=True)
    for index, ((px, py, yaw), (length, width)) in enumerate(boxes):
        reach = near + 0.5 * (length + width)
        if (
            -reach < px - x < reach
            and -reach < py - y < reach
            and all(side.depth > 0.0 for side in _sides(ego, (px, py, yaw), (length, width)))
        ):
            overlapping.append(index)
    return overlapping


def cause_of(
    ego: EgoState, pose: tuple[float, float, float], extent: tuple[float, float], speed: float
) -> str:
    """Return "other" if the other actor ran into the ego, else "ego".

    It is "other" if the ego was stationary, or if the contact is at the ego's side or rear and the
    other actor moved faster towards it than the ego.

    Args:
        ego: The ego vehicle.
        pose: The centre of the other actor's box and its yaw.
        extent: The other actor's length and width.
        speed: The other actor's speed.
    """
    if ego.speed < STATIONARY:
        return "other"
    nx, ny = _contact_normal(ego, pose, extent, speed)
    ahead = nx * math.cos(ego.yaw) + ny * math.sin(ego.yaw)
    if ahead > FRONT:
        return "ego"
    towards_ego = -speed * (nx * math.cos(pose[2]) + ny * math.sin(pose[2]))
    return "other" if towards_ego > ego.speed * ahead else "ego"


def _contact_normal(
    ego: EgoState, other: tuple[float, float, float], extent: tuple[float, float], speed: float
) -> tuple[float, float]:
    """Return the contact normal, pointing from the ego to the other actor.

    It is the one of the boxes' four axes along which, at the closing speed, they began to overlap
    last.
    """
    vx = ego.speed * math.cos(ego.yaw) - speed * math.cos(other[2])
    vy = ego.speed * math.sin(ego.yaw) - speed * math.sin(other[2])
    latest = min(
        _sides(ego, other, extent),
        key=lambda side: side.depth / max(vx * side.nx + vy * side.ny, 1e-6),
    )
    return latest.nx, latest.ny


class _Side(NamedTuple):
    """Overlap of two boxes along one axis, which points from the ego to the other actor."""

    nx: float
    ny: float
    depth: float


def _sides(
    ego: EgoState, other: tuple[float, float, float], extent: tuple[float, float]
) -> Iterator[_Side]:
    """Yield the overlap along the four candidate separating axes: two of each box."""
    dx, dy = other[0] - ego.x, other[1] - ego.y
    for yaw in (ego.yaw, ego.yaw + 0.5 * math.pi, other[2], other[2] + 0.5 * math.pi):
        nx, ny = math.cos(yaw), math.sin(yaw)
        apart = dx * nx + dy * ny
        if apart < 0.0:
            nx, ny, apart = -nx, -ny, -apart
        depth = _reach(ego.yaw - yaw, EGO_EXTENT) + _reach(other[2] - yaw, extent) - apart
        yield _Side(nx, ny, depth)


def _reach(turn: float, extent: tuple[float, float]) -> float:
    """Return a box's half-extent along an axis at the angle `turn` to it."""
    return 0.5 * (extent[0] * abs(math.cos(turn)) + extent[1] * abs(math.sin(turn)))
