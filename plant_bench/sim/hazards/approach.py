"""Ways through a junction that meet the ego's, and a vehicle brought there as the ego arrives."""

import math
import random
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PATH_POSES, PATH_STEP
from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.hazards.stage import CAR, Stage
from plant_bench.sim.traffic import COMFORTABLE_BRAKING
from plant_bench.world.route import Passage, Route
from plant_bench.world.town import Link, Town

TOUCH = 1.2  # m between two centre lines where the ways meet
ONWARD = 300.0  # m that a vehicle put out has to go behind the junction
BEYOND = 12.0  # m behind the junction within which ways may still meet
PULL = 2.5  # m/s2 with which a vehicle under command gains speed
LEAST_RUN = 35.0  # m before the meeting place at which a vehicle may be put out at the nearest
FROM_EGO = 45.0  # m from the ego at which a vehicle may be put out at the nearest
FROM_OTHERS = 14.0  # m kept to others on the lane when a vehicle is put out


@dataclass(frozen=True, eq=False)
class Approach:
    """A way through a junction that meets the ego's.

    Attributes:
        link: The way.
        line: Its centre line, from the begin of the incoming lanes to the end of the outgoing one.
        starts: Where on the line each lane begins, by lane id, in order.
        edges: The edges along the line.
        stop: Arc length of the stop line on the line.
        meets: Arc length on the line where the two ways first meet.
        at: Arc length on the ego's route of the same place.
        angle: From the ego's heading before the junction to that of the other, radians.
    """

    link: Link
    line: Float[np.ndarray, "points 2"]
    starts: dict[str, float]
    edges: tuple[str, ...]
    stop: float
    meets: float
    at: float
    angle: float


class Candidate(NamedTuple):
    """A vehicle that could meet the ego."""

    approach: Approach
    vehicle: int


def passage_at(route: Route, at: float) -> Passage | None:
    """Return the route's passage at an arc length, the nearest one within 10 m."""
    near = [item for item in route.passages if item.entry - 10.0 <= at <= item.exit + 10.0]
    return min(near, key=lambda item: abs(0.5 * (item.entry + item.exit) - at), default=None)


def approaches(town: Town, route: Route, passage: Passage) -> list[Approach]:
    """Return the ways that meet a passage of the ego's from other streets, in a fixed order."""
    span = route.along[(route.along >= passage.entry) & (route.along <= passage.exit + BEYOND)]
    own = np.stack([np.interp(span, route.along, route.points[:, axis]) for axis in (0, 1)], axis=1)
    heading = float(np.interp(passage.entry - 2.0, route.along, route.headings))
    edges = set(route.edges)
    found = []
    for link in town.links:
        if link.junction == passage.junction and link.via and link.source in town.lanes:
            source = town.lanes[link.source]
            if source.edge in edges and _same_heading(source.points, heading):
                continue
            approach = _approach(town, link, own, span, heading)
            if approach is not None:
                found.append(approach)
    return sorted(found, key=lambda item: (item.link.source, item.link.target))


def _same_heading(points: np.ndarray, heading: float) -> bool:
    dx, dy = points[-1, :2] - points[-2, :2]
    return math.cos(math.atan2(dy, dx) - heading) > 0.9


def _approach(
    town: Town, link: Link, own: np.ndarray, span: np.ndarray, heading: float
) -> Approach | None:
    first = town.lanes[link.source]
    lanes = [first, *(town.lanes[via] for via in link.via), town.lanes[link.target]]
    while (before := joined_before(town, lanes[0].id)) is not None and len(lanes) < 8:
        lanes.insert(0, town.lanes[before])
    line = np.concatenate([lane.points[:, :2] for lane in lanes])
    keep = np.concatenate(([True], np.hypot(*np.diff(line, axis=0).T) > 1e-3))
    starts, along = {}, 0.0
    for lane in lanes:
        starts[lane.id] = along
        along += lane.length
    stop = starts[link.via[0]]
    far = min(starts[link.target] + BEYOND, along)
    where = np.arange(stop, far, 0.5)
    line = line[keep]
    at = arc_lengths(line)
    other = np.stack([np.interp(where, at, line[:, axis]) for axis in (0, 1)], axis=1)
    apart = np.hypot(*(own[:, None] - other[None]).transpose(2, 0, 1))
    if apart.min(initial=math.inf) > TOUCH:
        return None
    mine = int(np.argmax(apart.min(axis=1) <= TOUCH))
    theirs = int(np.argmin(apart[mine]))
    dx, dy = first.points[-1, :2] - first.points[-2, :2]
    angle = (math.atan2(dy, dx) - heading + math.pi) % (2.0 * math.pi) - math.pi
    edges = tuple(lane.edge for lane in lanes if lane.junction is None)
    return Approach(link, line, starts, edges, stop, float(where[theirs]), float(span[mine]), angle)


def joined_before(town: Town, lane: str) -> str | None:
    """Return the lane before a lane where two edges just join."""
    for link in town.links:
        if link.target == lane and not link.via:
            return link.source
    return None


class Rival:
    """A vehicle under command on an approach; mutable.

    Args:
        stage: The world.
        approach: The way it takes.
        vehicle: Its number.
    """

    def __init__(self, stage: Stage, approach: Approach, vehicle: int) -> None:
        stage.command(vehicle)
        self.approach = approach
        self.vehicle = vehicle
        self._half = 0.5 * stage.kind_of(vehicle).length

    def front(self, stage: Stage) -> float | None:
        """Return where its front is on the approach's line; None when it is not there."""
        return place_on(stage, self.approach, self.vehicle)

    def speed(self, stage: Stage) -> float:
        """Return its speed, 0 when it is gone."""
        state = stage.state_of(self.vehicle)
        return 0.0 if state is None else state.speed

    def way_to_go(self, front: float) -> float:
        """Return the metres until its middle is where the ways meet."""
        return self.approach.meets + self._half - front

    def tell(self, stage: Stage, front: float) -> None:
        """Tell who may know it where the vehicle is going, whatever the lights show."""
        stage.paths[self.vehicle] = poses_on(self.approach.line, front - self._half)

    def let_go(self, stage: Stage) -> None:
        """Give it back to the traffic."""
        stage.hand_back(self.vehicle)


def place_on(stage: Stage, approach: Approach, vehicle: int) -> float | None:
    """Return where on an approach's line a vehicle's front is; None when it is not there."""
    state = stage.state_of(vehicle)
    if state is None or state.lane not in approach.starts:
        return None
    return approach.starts[state.lane] + stage.along_lane(state)


def speed_to_arrive(way: float, time: float, speed: float) -> float:
    """Return the speed to aim at, gained with `PULL`, to go a way in a time; infinite if late."""
    if way >= speed * time:
        reach = speed / PULL + time
        root = reach**2 - 2.0 / PULL * (way + speed**2 / (2.0 * PULL))
        return PULL * (reach - math.sqrt(root)) if root >= 0.0 else math.inf
    return max(way, 0.0) / max(time, 0.1)


def first_on(stage: Stage, approach: Approach) -> int | None:
    """Return the vehicle that is next to leave an approach's lanes, if any is there."""
    for lane in reversed(incoming(approach)):
        present = stage.lane_state(lane)
        if present:
            return present[-1][0]
    return None


def incoming(approach: Approach) -> list[str]:
    """Return the lanes before the stop line, in order."""
    return [
        lane
        for lane, start in approach.starts.items()
        if start < approach.stop and not lane.startswith(":")
    ]


def put_out(
    stage: Stage, approach: Approach, way: float, speed: float, draw: random.Random
) -> int | None:
    """Ask for a vehicle on an approach; None where its place is taken or too near.

    Args:
        stage: The world.
        approach: Where.
        way: Metres from its middle to the meeting place.
        speed: m/s that it has, at most the lane's limit.
        draw: Where it goes on behind the junction.
    """
    front = approach.meets + 0.5 * CAR.length - way
    if way < LEAST_RUN or front < CAR.length or front > approach.stop - 5.0:
        return None
    at = arc_lengths(approach.line)
    x, y = (float(np.interp(front, at, approach.line[:, axis])) for axis in (0, 1))
    ego_x, ego_y, _ = stage.pose_at(stage.progress)
    if math.hypot(x - ego_x, y - ego_y) < FROM_EGO:
        return None
    for lane in incoming(approach):
        for _, position, _ in stage.lane_state(lane):
            if abs(approach.starts[lane] + position - front) < FROM_OTHERS:
                return None
    lane_id = [lane for lane in incoming(approach) if approach.starts[lane] <= front][-1]
    lane = stage.town.lanes[lane_id]
    if front > approach.starts[lane_id] + lane.length - 1.0:
        return None  # inside a junction
    at_lane = front - approach.starts[lane_id]
    room = math.sqrt(2.0 * COMFORTABLE_BRAKING * max(lane.length - at_lane - 5.0, 0.0))
    edges = approach.edges[approach.edges.index(lane.edge) :]
    onward = walk(stage.town, edges[-1], draw)
    return stage.send(CAR, (*edges, *onward), lane, at_lane, min(speed, lane.speed_limit, room))


def walk(town: Town, edge: str, draw: random.Random) -> list[str]:
    """Return a random walk of edges that begins after an edge."""
    edges: list[str] = []
    length = 0.0
    while length < ONWARD:
        ways = [link for lane in town.edges[edge] for link in town.links_from.get(lane.id, ())]
        if not ways:
            break
        edge = town.lanes[draw.choice(ways).target].edge
        edges.append(edge)
        length += town.edges[edge][0].length
    return edges


def poses_on(line: Float[np.ndarray, "points 2"], along: float) -> Float[np.ndarray, "steps 3"]:
    """Return the poses of a privileged path on a polyline from an arc length on."""
    at = arc_lengths(line)
    where = np.minimum(along + PATH_STEP * np.arange(PATH_POSES), at[-1])
    x, y = np.interp(where, at, line[:, 0]), np.interp(where, at, line[:, 1])
    before, after = np.maximum(where - 1.0, 0.0), np.minimum(where + 1.0, at[-1])
    dx = np.interp(after, at, line[:, 0]) - np.interp(before, at, line[:, 0])
    dy = np.interp(after, at, line[:, 1]) - np.interp(before, at, line[:, 1])
    return np.stack((x, y, np.arctan2(dy, dx)), axis=1)
