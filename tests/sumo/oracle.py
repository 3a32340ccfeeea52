"""Short drives past one hazard on an empty road, by an oracle and by a blind driver."""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from plant_bench.agent import Control, Input, Observation, Privileged, RouteAhead
from plant_bench.agents.careful.leader import corridor
from plant_bench.agents.idm import idm, light_limit
from plant_bench.controller import follow_route
from plant_bench.features.limits import allowed_speed
from plant_bench.geometry.box import overlap_one
from plant_bench.geometry.polyline import Cursor
from plant_bench.sensing.observe import Sensors
from plant_bench.sim.simulation import Simulation
from plant_bench.world.hazard import Hazard, Phase
from plant_bench.world.route import Route, Scenario
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, EGO_WIDTH, Actors

REACTION = 0.5  # s from commitment
BRAKING = 4.0  # m/s2 at most, everywhere
FIRM = 2.0  # m/s2 needed to stop from which on it brakes with all it has
BESIDE = 0.5 * EGO_WIDTH + 0.15  # m from the route that the ego takes
INSIDE = 1.0  # m in a conflict from which on it is better to be out of it
SHORT_OF = 0.3  # m before a conflict at which it stops
HORIZON = 9.0  # s that others are followed into the future
SPARE_TIME = 1.0  # s between the ego leaving and another coming
PULL_AWAY = 2.0  # m/s2
RUN_UP = 130.0  # m of route before the hazard, to reach the posted speed
RUN_OUT = 70.0  # m of route behind it
PATIENCE = 240.0  # s until a drive is given up: two long red lights are waited for
ALL = frozenset(Input)


class Zone(NamedTuple):
    """A conflict with another actor's path: arc lengths ahead of the ego's centre, and times."""

    begin: float
    end: float
    first: float
    last: float


class Drive(NamedTuple):
    """The outcome of one drive."""

    phase: Phase
    reason: str
    committed: bool
    hit: bool
    arrived: bool
    aside: float


@dataclass
class Oracle:
    """Knows the hazard: reacts half a second after it is committed; mutable."""

    route: Route
    committed: float = math.inf
    braked: float = field(default=0.0)

    def act(self, seen: Observation, committed: bool) -> Control:
        """Drive, follow the leader, and stop for crossing actors once the hazard is committed."""
        route, ego, actors, facts = seen.route, seen.ego, seen.actors, seen.privileged
        assert route is not None
        assert actors is not None
        assert facts is not None
        if committed:
            self.committed = min(self.committed, seen.time)
        target = allowed_speed(route)
        pull = min(idm(ego.speed, target), light_limit(ego.speed, seen.light))
        if len(actors):
            ahead = corridor(route, actors, route.past, ego.speed)
            leader = ahead.leader()
            gap = leader.distance - 0.5 * EGO_LENGTH
            pull = min(pull, idm(ego.speed, target, gap, leader.speed))
            if seen.time >= self.committed + REACTION:
                follows = ahead.inside & ~ahead.crossing & (ahead.speeds > 0.5)
                zones = conflict_zones(route, actors, facts, ~follows)
                pull = min(pull, self._yield(route, ego.speed, zones))
        return Control(max(pull, -BRAKING), follow_route(ego, route))

    def _yield(self, route: RouteAhead, speed: float, zones: list[Zone]) -> float:
        pull = math.inf
        for zone in zones:
            distance = zone.begin - 0.5 * EGO_LENGTH
            leave = time_to_drive(speed, zone.end + 0.5 * EGO_LENGTH, allowed_speed(route))
            inside = distance < -INSIDE
            if zone.first > leave + (0.0 if inside else SPARE_TIME) or zone.end < 0.0:
                continue
            if inside and speed < 0.1 and zone.first < 0.1:
                continue  # stands, and the other has come past
            pull = min(pull, stop_before(speed, self._line(route, speed, distance)))
        return pull

    def _line(self, route: RouteAhead, speed: float, distance: float) -> float:
        """Prefer to wait at a junction's stop line rather than inside it."""
        front = route.progress + 0.5 * EGO_LENGTH
        for passage in self.route.passages:
            line = passage.entry - front
            inside = passage.entry < front + distance < passage.exit + EGO_LENGTH
            if inside and line > 0.0 and speed**2 / (2.0 * line) < BRAKING - 1.0:
                return line
        return distance - SHORT_OF


def stop_before(speed: float, distance: float) -> float:
    """Return the acceleration that stops within a distance: late and hard."""
    if distance <= 0.05:
        return -BRAKING
    needed = speed**2 / (2.0 * distance)
    if needed > FIRM:
        return -BRAKING
    return math.inf if distance > 0.5 + speed**2 / 2.0 + speed else -needed if speed else -1.0


def time_to_drive(speed: float, distance: float, most: float) -> float:
    """Return the time for a distance, speeding up to the limit."""
    most = max(most, speed, 1.0)
    ramp = (most**2 - speed**2) / (2.0 * PULL_AWAY)
    if ramp >= distance:
        return (math.sqrt(speed**2 + 2.0 * PULL_AWAY * max(distance, 0.0)) - speed) / PULL_AWAY
    return (most - speed) / PULL_AWAY + (distance - ramp) / most


def conflict_zones(
    route: RouteAhead, actors: Actors, facts: Privileged, consider: np.ndarray
) -> list[Zone]:
    """Return where and when the known paths of other actors conflict with the ego's path."""
    zones = []
    for index in np.flatnonzero(consider):
        speed, path = float(actors.speeds[index]), facts.paths[index]
        length, width = actors.extents[index].astype(float)
        poses = 1 if speed < 0.1 else min(int(speed * HORIZON) + 2, len(path))
        here = np.concatenate((actors.poses[index][None].astype(float), path[1:poses]))
        along, aside = _hold(route, here, length, width)
        taken = (np.abs(aside) < BESIDE) & (along > 0.0)
        rows = np.flatnonzero(taken.any(axis=1))
        if rows.size:
            times = rows / max(speed, 0.1)
            places = along[taken]
            zones.append(Zone(places.min(), places.max(), float(times[0]), float(times[-1])))
    return zones


def _hold(
    route: RouteAhead, poses: np.ndarray, length: float, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return place along and beside the route of points all over the boxes."""
    grid = np.array(
        [(a * length, b * width) for a in np.linspace(-0.5, 0.5, 7) for b in (-0.5, 0.0, 0.5)]
    )
    cos, sin = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    x = poses[:, 0, None] + cos * grid[:, 0] - sin * grid[:, 1]
    y = poses[:, 1, None] + sin * grid[:, 0] + cos * grid[:, 1]
    dx, dy = x[..., None] - route.points[:, 0], y[..., None] - route.points[:, 1]
    near = np.argmin(dx * dx + dy * dy, axis=2)
    gap_x, gap_y = x - route.points[near, 0], y - route.points[near, 1]
    heading = route.headings[near]
    along = near + np.cos(heading) * gap_x + np.sin(heading) * gap_y - route.past
    aside = np.cos(heading) * gap_y - np.sin(heading) * gap_x
    beyond = (near == len(route.points) - 1) | (along < 0.0)
    return along, np.where(beyond, math.inf, aside)


def cut(route: Route, hazard: Hazard) -> tuple[Route, Hazard]:
    """Return the stretch of a route around a hazard, and the hazard on it."""
    inside = [(passage.entry - 8.0, passage.exit + 5.0) for passage in route.passages]
    start = max(min(hazard.arm - 15.0, hazard.at - RUN_UP), 0.0)
    for entry, leave in reversed(inside):
        if entry < start < leave:
            start = max(entry - 5.0, 0.0)
    first, last = int(start), min(int(hazard.at + RUN_OUT), len(route.points) - 1)
    from_edge = next(
        span.lane.rsplit("_", 1)[0]
        for span in route.lanes
        if span.end > first and not span.lane.startswith(":")
    )
    back = float(route.along[first])
    points = slice(first, last + 1)
    end = float(route.along[last])
    short = replace(
        route,
        id=f"{route.id}@{hazard.at:.0f}",
        points=route.points[points],
        elevations=route.elevations[points],
        speed_limits=route.speed_limits[points],
        edges=route.edges[route.edges.index(from_edge) :],
        lanes=tuple(
            replace(span, start=max(span.start - back, 0.0), end=min(span.end, end) - back)
            for span in route.lanes
            if span.end > back and span.start < end
        ),
        passages=tuple(
            replace(passage, entry=passage.entry - back, exit=passage.exit - back)
            for passage in route.passages
            if passage.entry > back and passage.exit < end + 30.0
        ),
        lane_changes=tuple(
            replace(change, start=change.start - back, end=change.end - back)
            for change in route.lane_changes
            if change.start > back and change.end < end
        ),
    )
    moved = replace(hazard, at=hazard.at - back, arm=max(hazard.arm - back, 0.0))
    return replace(short, hazards=(moved,)), moved


def drive(route: Route, hazard: Hazard, seed: int, *, blind: bool) -> Drive:
    """Drive past one hazard on an otherwise empty road."""
    short, hazard = cut(route, hazard)
    oracle, cursor = Oracle(short), Cursor(short.points)
    hit, was_committed, aside = False, False, 0.0
    with Simulation(Scenario(short, seed, "empty", hazards=True)) as simulation:
        scene = simulation.scene
        while not hit and scene.time < PATIENCE:
            ego, actors = scene.ego, scene.actors
            cursor.advance(ego.x, ego.y)
            outcome = simulation.outcomes[0]
            was_committed |= outcome.phase is Phase.COMMITTED
            aside = max(aside, abs(cursor.offset))
            hit = bool(overlap_one(ego.pose, EGO_EXTENT, actors.poses, actors.extents).any())
            over = outcome.phase in (Phase.DONE, Phase.VOID)
            if over and (cursor.progress > hazard.at + 25.0 or outcome.phase is Phase.VOID):
                break
            if cursor.progress > short.length - 5.0:
                break
            facts = simulation.privileged()
            seen = Sensors(short, 0, ALL).observe(scene, cursor.progress, cursor.offset, facts)
            control = oracle.act(seen, was_committed and not blind)
            if blind:
                control = _cruise(seen)
            scene = simulation.step(control)
        outcome = simulation.outcomes[0]
    arrived = cursor.progress > min(hazard.at + 20.0, short.length - 8.0)
    return Drive(outcome.phase, outcome.reason, was_committed, hit, arrived, aside)


def _cruise(seen: Observation) -> Control:
    """Drive by the speed limits and lights; ignore all actors."""
    assert seen.route is not None
    pull = min(
        idm(seen.ego.speed, allowed_speed(seen.route)), light_limit(seen.ego.speed, seen.light)
    )
    return Control(pull, follow_route(seen.ego, seen.route))
