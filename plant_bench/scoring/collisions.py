"""What counts as a collision, and who ran into whom (CARLA leaderboard 1.0)."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from plant_bench.scoring.infractions import InfractionKind
from plant_bench.world.scene import EGO_EXTENT, TICK, ActorKind, Actors, EgoState, Scene

# CollisionTest of scenario_runner 1.0, atomic_criteria.py.
SAME_PLACE = 3.0  # m: a contact this near an earlier one is the same (MIN_AREA_OF_COLLISION)
PLACE_FORGOTTEN = 5.0  # m: ... until the ego is this far from it (MAX_AREA_OF_COLLISION)
ACTOR_FORGOTTEN = 5.0  # s without contact: then the last actor counts anew (MAX_ID_TIME)
STANDING = 0.1  # m/s (leaderboard 2.0, CollisionTest: slower is not the ego's collision)
FRONT = math.cos(math.radians(45.0))  # own choice: what of a contact's normal is "ahead"

COLLISION_KINDS = {
    ActorKind.PEDESTRIAN: InfractionKind.COLLISION_PEDESTRIAN,
    ActorKind.STATIC: InfractionKind.COLLISION_STATIC,
}  # every other kind is a vehicle


class Collision(NamedTuple):
    """A collision that counts.

    Attributes:
        kind: Pedestrian, vehicle or static.
        actor: The other's id.
        actor_kind: What it is.
        cause: "other" if the other ran into the ego, else "ego".
    """

    kind: InfractionKind
    actor: int
    actor_kind: ActorKind
    cause: str


class Collisions:
    """Tells new collisions from contacts that were counted already; mutable."""

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
            for index in touching(ego, actors)
            if self._counts(scene, index)
        ]

    def _forget(self, tick: int, ego: EgoState) -> None:
        if self._places:
            self._places = [
                place
                for place in self._places
                if math.hypot(ego.x - place[0], ego.y - place[1]) <= PLACE_FORGOTTEN
            ]
        if self._last_actor is not None and (tick - self._last_contact) * TICK > ACTOR_FORGOTTEN:
            self._last_actor = None

    def _counts(self, scene: Scene, index: int) -> bool:
        """Decide on one contact, and remember it."""
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


def touching(ego: EgoState, actors: Actors) -> list[int]:
    """Return which actors' boxes overlap the ego's (touching edges do not).

    Plain Python on purpose: few actors are near, and this runs at every tick.
    """
    x, y, near = ego.x, ego.y, 0.5 * sum(EGO_EXTENT)
    found = []
    boxes = zip(actors.poses.tolist(), actors.extents.tolist(), strict=True)
    for index, ((px, py, yaw), (length, width)) in enumerate(boxes):
        reach = near + 0.5 * (length + width)
        if (
            -reach < px - x < reach
            and -reach < py - y < reach
            and all(side.depth > 0.0 for side in _sides(ego, (px, py, yaw), (length, width)))
        ):
            found.append(index)
    return found


def cause_of(
    ego: EgoState, pose: tuple[float, float, float], extent: tuple[float, float], speed: float
) -> str:
    """Return "other" if the other ran into the ego, else "ego".

    The other did when the ego stood, or when they met at the ego's side or rear and the other was
    the faster one towards the place where they met.

    Args:
        ego: The ego vehicle.
        pose: The other's box centre.
        extent: The other's length and width.
        speed: The other's speed.
    """
    if ego.speed < STANDING:
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
    """Return the direction from the ego to the other in which the boxes came to overlap last.

    Of the boxes' four axes it is the one where the overlap, at the speed of closing, is youngest.
    """
    vx = ego.speed * math.cos(ego.yaw) - speed * math.cos(other[2])
    vy = ego.speed * math.sin(ego.yaw) - speed * math.sin(other[2])
    youngest = min(
        _sides(ego, other, extent),
        key=lambda side: side.depth / max(vx * side.nx + vy * side.ny, 1e-6),
    )
    return youngest.nx, youngest.ny


class _Side(NamedTuple):
    """How deep two boxes overlap along one axis, which points from the ego to the other."""

    nx: float
    ny: float
    depth: float


def _sides(
    ego: EgoState, other: tuple[float, float, float], extent: tuple[float, float]
) -> Iterator[_Side]:
    """Yield the four axes that can part two boxes: those of the ego and those of the other."""
    dx, dy = other[0] - ego.x, other[1] - ego.y
    for yaw in (ego.yaw, ego.yaw + 0.5 * math.pi, other[2], other[2] + 0.5 * math.pi):
        nx, ny = math.cos(yaw), math.sin(yaw)
        apart = dx * nx + dy * ny
        if apart < 0.0:
            nx, ny, apart = -nx, -ny, -apart
        depth = _reach(ego.yaw - yaw, EGO_EXTENT) + _reach(other[2] - yaw, extent) - apart
        yield _Side(nx, ny, depth)


def _reach(turn: float, extent: tuple[float, float]) -> float:
    """Return how far a box reaches from its centre along an axis that it is turned from."""
    return 0.5 * (extent[0] * abs(math.cos(turn)) + extent[1] * abs(math.sin(turn)))
