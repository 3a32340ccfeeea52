"""Where the time of an episode went: how long the ego was stationary, where and why."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from plant_bench.agent import NO_ACTOR, Cause, Input, Reason
from plant_bench.agents.careful.leader import corridor
from plant_bench.data.recording import Recording
from plant_bench.scoring.termination import BLOCKED_SPEED
from plant_bench.sensing.observe import Sensors
from plant_bench.world.route import Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import EGO_LENGTH, TICK, ActorKind, Light, Scene

CLOSE = 12.0  # m from the ego's front: a red light or an actor this close explains a stop
SAMPLED = 20  # ticks between two evaluations of a stationary scene without recorded reasons
NOTHING = Reason(Cause.FREE)


@dataclass(frozen=True)
class Stop:
    """A time in which the ego was stationary.

    Attributes:
        start: When it began, seconds.
        seconds: Its duration.
        progress: Metres along the route.
        reason: The reason that lasted longest.
        kind: Kind of the actor of the reason; None if there is none.
    """

    start: float
    seconds: float
    progress: float
    reason: Reason
    kind: ActorKind | None


@dataclass(frozen=True)
class TimeUse:
    """Where the time of an episode went.

    Attributes:
        seconds: Duration of the episode.
        stationary: Seconds for which the ego was stationary, by cause, the longest first.
        stops: All stops, the longest first.
        recorded: Whether the reasons are those that the planner recorded; else they follow from
            the scenes: a red light or an actor close ahead.
    """

    seconds: float
    stationary: dict[Cause, float]
    stops: tuple[Stop, ...]
    recorded: bool


def time_use_of(recording: Recording, seed: int, route: Route) -> TimeUse:
    """Return where the time of an episode went.

    Args:
        recording: Recording of every tick.
        seed: The scenario's seed.
        route: The route it was driven on.
    """
    reasons = _held(recording.reasons)
    recorded = any(reason is not None for reason in reasons)
    speeds = [scene.ego.speed for scene in recording]
    position = RouteProgress(route)
    along = [_follow(position, scene) for scene in recording]
    if not recorded:
        reasons = _from_scenes(recording, speeds, along, seed, route)
    stationary: dict[Cause, float] = {}
    stops = []
    for rows in _stops(speeds):
        named = [reasons[row] or NOTHING for row in rows]
        for reason in named:
            stationary[reason.cause] = stationary.get(reason.cause, 0.0) + TICK
        main = max(dict.fromkeys(named), key=named.count)
        stops.append(
            Stop(
                start=recording[rows[0]].time,
                seconds=len(rows) * TICK,
                progress=along[rows[0]][0],
                reason=main,
                kind=_kind(recording[rows[named.index(main)]], main.actor),
            )
        )
    return TimeUse(
        seconds=len(recording) * TICK,
        stationary=dict(sorted(stationary.items(), key=lambda item: -item[1])),
        stops=tuple(sorted(stops, key=lambda stop: -stop.seconds)),
        recorded=recorded,
    )


def _held(reasons: Sequence[Reason | None]) -> list[Reason | None]:
    """Return the reason of the latest decision at each tick."""
    held: list[Reason | None] = []
    for reason in reasons:
        held.append(reason if reason is not None else held[-1] if held else None)
    return held


def _stops(speeds: Sequence[float]) -> Iterator[list[int]]:
    """Yield the rows of each stop."""
    for stationary, rows in groupby(range(len(speeds)), lambda row: speeds[row] < BLOCKED_SPEED):
        if stationary:
            yield list(rows)


def _follow(position: RouteProgress, scene: Scene) -> tuple[float, float]:
    position.follow(scene.ego.x, scene.ego.y)
    return position.progress, position.offset


def _from_scenes(
    recording: Recording,
    speeds: Sequence[float],
    along: Sequence[tuple[float, float]],
    seed: int,
    route: Route,
) -> list[Reason | None]:
    """Return a reason for each stationary row from what is close ahead in its scene."""
    sensors = Sensors(route, seed, frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT}))
    reasons: list[Reason | None] = [None] * len(speeds)
    for rows in _stops(speeds):
        for first in range(0, len(rows), SAMPLED):
            row = rows[first]
            reason = _reason_in(sensors, recording[row], *along[row])
            for same in rows[first : first + SAMPLED]:
                reasons[same] = reason
    return reasons


def _reason_in(sensors: Sensors, scene: Scene, progress: float, offset: float) -> Reason:
    seen = sensors.observe(scene, progress, offset)
    actors, route, light = seen.actors, seen.route, seen.light
    gap, actor = np.inf, NO_ACTOR
    if actors is not None and route is not None and len(actors) and len(route.points) > 1:
        held = corridor(route, actors, route.past, scene.ego.speed)
        nearest = np.where(held.inside, held.nearest, np.inf) - 0.5 * EGO_LENGTH
        gap, actor = float(nearest.min()), int(actors.ids[int(np.argmin(nearest))])
    red = light is not None and light.state in (Light.RED, Light.YELLOW)
    if light is not None and red and light.distance <= min(CLOSE, gap):
        return Reason(Cause.LIGHT)
    return Reason(Cause.LEADER, actor) if gap <= CLOSE else NOTHING


def _kind(scene: Scene, actor: int) -> ActorKind | None:
    rows = np.flatnonzero(scene.actors.ids == actor)
    return ActorKind(int(scene.actors.kinds[rows[0]])) if rows.size else None
