"""Estimates when the ego, or a vehicle under command, reaches a place."""

import math

import numpy as np

from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.driver_braking import CURVE_BRAKING
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import EGO_LENGTH, EgoState

ACCELERATION = 2.5  # m/s2 of a vehicle under command
EGO_ACCELERATION = 2.0  # m/s2, assumed
START_DELAY = 0.3  # s until the ego starts at a green light
QUEUE_TIME, QUEUE_SPACING = 1.2, 7.5  # s and m per queued vehicle in front of the ego
QUEUE_SPEED = 2.0  # m/s below which a vehicle counts as queued
SPACING = 2.0  # m between the points at which the ego's drive is computed
STOPPED_SPEED = 1.0  # m/s below which the ego counts as waiting


def speed_to_arrive(distance: float, time: float, speed: float) -> float:
    """Return the target speed to cover a distance in a time; infinite if that is impossible."""
    if distance >= speed * time:
        reach = speed / ACCELERATION + time
        root = reach**2 - 2.0 / ACCELERATION * (distance + speed**2 / (2.0 * ACCELERATION))
        return ACCELERATION * (reach - math.sqrt(root)) if root >= 0.0 else math.inf
    return max(distance, 0.0) / max(time, 0.1)


def time_to_go(distance: float, speed: float, pace: float) -> float:
    """Return the time for a distance, accelerating by `ACCELERATION` up to a pace."""
    if pace <= speed:
        return max(distance, 0.0) / max(pace, 0.1)
    ramp = (pace**2 - speed**2) / (2.0 * ACCELERATION)
    if ramp >= distance:
        return (
            math.sqrt(speed**2 + 2.0 * ACCELERATION * max(distance, 0.0)) - speed
        ) / ACCELERATION
    return (pace - speed) / ACCELERATION + (distance - ramp) / pace


def drive_time(route: Route, speed: float, begin: float, end: float) -> float:
    """Return the least time for a stretch of a route within its speed limits.

    Args:
        route: The ego's route.
        speed: Speed at the start, m/s.
        begin: Arc length of the start, metres.
        end: Arc length of the end, metres.
    """
    count = max(math.ceil((end - begin) / SPACING), 1)
    step = max(end - begin, 0.0) / count
    places = begin + step * np.arange(count + 1)
    caps = np.maximum(np.interp(places, route.along, route.speed_limits), 1.0).tolist()
    for k in range(count - 1, -1, -1):
        caps[k] = min(caps[k], math.sqrt(caps[k + 1] ** 2 + 2.0 * CURVE_BRAKING * step))
    time = 0.0
    for k in range(count):
        after = min(
            math.sqrt(speed**2 + 2.0 * EGO_ACCELERATION * step),
            max(caps[k + 1], speed - 0.3 * step),
        )
        time += 2.0 * step / max(speed + after, 0.1)
        speed = after
    return time


def expected_arrival(
    ego: EgoState, world: HazardWorld, along: float, passage: Passage | None = None
) -> float:
    """Return the earliest time until the ego's centre reaches an arc length of its route.

    Args:
        ego: The ego's state.
        world: The world.
        along: The arc length, metres.
        passage: The passage whose light and queue the ego waits for.
    """
    free = drive_time(world.route, ego.speed, world.progress, along)
    if passage is None or (line := passage.entry - 0.5 * EGO_LENGTH) < world.progress:
        return free
    queue = _queue(ego, world, passage)
    wait = world.opens_in(passage) + QUEUE_TIME * queue
    reach = drive_time(world.route, ego.speed, world.progress, line)
    if wait == 0.0 or (ego.speed >= STOPPED_SPEED and reach >= wait):
        return free
    begin = world.progress if ego.speed < STOPPED_SPEED else line - QUEUE_SPACING * queue
    return wait + START_DELAY + drive_time(world.route, 0.0, max(begin, world.progress), along)


def _queue(ego: EgoState, world: HazardWorld, passage: Passage) -> int:
    """Return the number of vehicles queued in front of the ego at a passage's stop line."""
    lane = world.lane_at(passage.entry - 1.0)
    if lane is None:
        return 0
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    return sum(
        state.lane == lane.id
        and state.speed < QUEUE_SPEED
        and cos * (state.x - ego.x) + sin * (state.y - ego.y) > EGO_LENGTH
        for state in world.seen().values()
    )
