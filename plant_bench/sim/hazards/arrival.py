"""When the ego, and another vehicle, are at a place."""

import math

import numpy as np

from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.driver_braking import CURVE_BRAKING
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import EGO_LENGTH, EgoState

PULL = 2.5  # m/s2 with which a vehicle under command gains speed
GAIN = 2.0  # m/s2 that the ego is thought to speed up with
START = 0.3  # s until the ego goes when it may
QUEUE_TIME, QUEUE_ROOM = 1.2, 7.5  # s and m for each that stands before the ego
SLOW = 2.0  # m/s below which one is in a queue
SPACING = 2.0  # m between the places at which the ego's drive is computed
STANDS = 1.0  # m/s below which the ego waits where it is


def speed_to_arrive(way: float, time: float, speed: float) -> float:
    """Return the speed to aim at, gained with `PULL`, to go a way in a time; infinite if late."""
    if way >= speed * time:
        reach = speed / PULL + time
        root = reach**2 - 2.0 / PULL * (way + speed**2 / (2.0 * PULL))
        return PULL * (reach - math.sqrt(root)) if root >= 0.0 else math.inf
    return max(way, 0.0) / max(time, 0.1)


def time_to_go(way: float, speed: float, pace: float) -> float:
    """Return the time for a way, with speed gained by `PULL` up to a pace."""
    if pace <= speed:
        return max(way, 0.0) / max(pace, 0.1)
    ramp = (pace**2 - speed**2) / (2.0 * PULL)
    if ramp >= way:
        return (math.sqrt(speed**2 + 2.0 * PULL * max(way, 0.0)) - speed) / PULL
    return (pace - speed) / PULL + (way - ramp) / pace


def drive_time(route: Route, speed: float, begin: float, end: float) -> float:
    """Return the least time for a stretch of a route, its speed limits and bends minded.

    Args:
        route: The ego's.
        speed: m/s at the begin.
        begin: Arc length, metres.
        end: Arc length, metres.
    """
    count = max(math.ceil((end - begin) / SPACING), 1)
    step = max(end - begin, 0.0) / count
    places = begin + step * np.arange(count + 1)
    caps = np.maximum(np.interp(places, route.along, route.speed_limits), 1.0).tolist()
    for k in range(count - 1, -1, -1):
        caps[k] = min(caps[k], math.sqrt(caps[k + 1] ** 2 + 2.0 * CURVE_BRAKING * step))
    time = 0.0
    for k in range(count):
        after = min(math.sqrt(speed**2 + 2.0 * GAIN * step), max(caps[k + 1], speed - 0.3 * step))
        time += 2.0 * step / max(speed + after, 0.1)
        speed = after
    return time


def expected_arrival(
    ego: EgoState, stage: HazardWorld, along: float, passage: Passage | None = None
) -> float:
    """Return the soonest time in which the ego's middle is at an arc length of its route.

    Args:
        ego: Its state.
        stage: The world.
        along: The arc length, metres.
        passage: Whose light the ego waits for, with those who stand before it.
    """
    free = drive_time(stage.route, ego.speed, stage.progress, along)
    if passage is None or (line := passage.entry - 0.5 * EGO_LENGTH) < stage.progress:
        return free
    queue = _queue(ego, stage, passage)
    wait = stage.opens_in(passage) + QUEUE_TIME * queue
    reach = drive_time(stage.route, ego.speed, stage.progress, line)
    if wait == 0.0 or (ego.speed >= STANDS and reach >= wait):
        return free
    begin = stage.progress if ego.speed < STANDS else line - QUEUE_ROOM * queue
    return wait + START + drive_time(stage.route, 0.0, max(begin, stage.progress), along)


def _queue(ego: EgoState, stage: HazardWorld, passage: Passage) -> int:
    """Return how many stand before the ego at a passage's line."""
    lane = stage.lane_at(passage.entry - 1.0)
    if lane is None:
        return 0
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    return sum(
        state.lane == lane.id
        and state.speed < SLOW
        and cos * (state.x - ego.x) + sin * (state.y - ego.y) > EGO_LENGTH
        for state in stage.seen().values()
    )
