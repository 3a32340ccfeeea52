"""Where the background vehicles will truly go: their lane paths, as poses of the box centre."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PATH_POSES, PATH_STEP, Privileged
from plant_bench.geometry.polyline import arc_lengths
from plant_bench.sim.sumo import NextLink, Sumo, VehicleState
from plant_bench.world.scene import TICK, Actors
from plant_bench.world.town import Lane, Town

REFRESH = 4  # ticks between two looks at a vehicle's links: the drivers' own action step
BEHIND = 8.0  # m of path kept behind the lane's begin: a vehicle's rear hangs over it
REACH = BEHIND + (PATH_POSES + 2) * PATH_STEP  # m of path from the present lane's begin, at least
LANE_CHANGE_SPEED = 0.05  # m/s sideways, above which a vehicle is changing lanes
STOPPED = 0.1  # m/s
OPEN_STATES = "GgMmOo=wsZ"  # SUMO's link states other than red and yellow


@dataclass
class _Track:
    """What is remembered of one vehicle; mutable."""

    lane: str
    poses: Float[np.ndarray, "samples 3"]
    stop: float
    refreshed: int
    factor: float
    behind: str | None = None
    stopped_since: int | None = None


class LanePaths:
    """Follows the watched vehicles and tells the privileged facts of each; mutable.

    Args:
        sumo: The running simulation.
        town: The town's lanes.
    """

    def __init__(self, sumo: Sumo, town: Town) -> None:
        self._sumo = sumo
        self._town = town
        self._tracks: dict[int, _Track] = {}

    def facts(
        self, tick: int, actors: Actors, states: dict[int, VehicleState]
    ) -> Privileged:
        """Return the facts of the actors of one scene, in their order."""
        ids = actors.ids.tolist()
        count = len(ids)
        paths = np.empty((count, PATH_POSES, 3))
        stops, limits = np.empty(count), np.empty(count)
        waited = np.zeros(count)
        lengths = actors.extents[:, 0].tolist()
        for row, (vehicle, length) in enumerate(zip(ids, lengths, strict=True)):
            state = states[vehicle]
            track = self._track(tick, vehicle, state)
            lane = self._town.lanes[state.lane] if state.lane in self._town.lanes else None
            at = state.lane_position * self._scale(lane)
            paths[row] = _ahead(track.poses, at - 0.5 * length)
            stops[row] = track.stop - at
            limits[row] = track.factor * (lane.speed_limit if lane else state.speed)
            waited[row] = self._waited(tick, track, state)
            if abs(state.lateral) > LANE_CHANGE_SPEED:
                _shift(paths[row], actors.poses[row], state, lane)
        self._forget(tick)
        return Privileged(
            paths=paths,
            accelerations=np.array([states[vehicle].acceleration for vehicle in ids]),
            desired_speeds=limits,
            stop_distances=stops,
            stopped_for=waited,
        )

    def _scale(self, lane: Lane | None) -> float:
        return lane.length / self._sumo.lane_length(lane.id) if lane else 1.0

    def _track(self, tick: int, vehicle: int, state: VehicleState) -> _Track:
        track = self._tracks.get(vehicle)
        due = track is None or (tick + vehicle) % REFRESH == 0 or tick - track.refreshed > REFRESH
        if track is not None and track.lane == state.lane and not due:
            return track
        links = self._sumo.next_links(vehicle)
        behind = None if track is None else track.behind
        if track is not None and track.lane != state.lane:
            behind = track.lane if state.lane in self._successors(track.lane) else None
        lanes = self._lanes(state.lane, links)
        poses = self._poses(behind, lanes)
        factor = track.factor if track else self._sumo.desired_speed_factor(vehicle)
        since = track.stopped_since if track else None
        stop = self._stop(state, lanes, links)
        track = _Track(state.lane, poses, stop, tick, factor, behind, since)
        self._tracks[vehicle] = track
        return track

    def _forget(self, tick: int) -> None:
        if tick % 100 == 0:
            fresh = {key: track for key, track in self._tracks.items() if tick - track.refreshed < 100}
            self._tracks = fresh

    def _waited(self, tick: int, track: _Track, state: VehicleState) -> float:
        if state.speed > STOPPED:
            track.stopped_since = None
            return 0.0
        if track.stopped_since is None:
            track.stopped_since = tick
        return (tick - track.stopped_since) * TICK

    def _successors(self, lane: str) -> tuple[str, ...]:
        found = self._town.lanes.get(lane)
        return found.successors if found else ()

    def _lanes(self, first: str, links: list[NextLink]) -> list[str]:
        """Return the lanes from the present one on, internal ones included."""
        lanes = [first]
        for link in links:
            lanes += self._through(lanes[-1], link)
            if self._length(lanes) > REACH:
                break
        while self._length(lanes) < REACH:
            onward = self._successors(lanes[-1])
            if not onward:
                break
            lanes.append(onward[0])
        return [lane for lane in lanes if lane in self._town.lanes]

    def _through(self, source: str, link: NextLink) -> list[str]:
        inner: list[str] = []
        lane = link.via
        while lane and lane != link.target and len(inner) < 8:
            if lane != source:
                inner.append(lane)
            lane = next(iter(self._successors(lane)), "")
        return [*inner, link.target]

    def _length(self, lanes: list[str]) -> float:
        known = self._town.lanes
        return sum(known[lane].length for lane in lanes if lane in known)

    def _poses(self, behind: str | None, lanes: list[str]) -> Float[np.ndarray, "samples 3"]:
        """Return poses every metre, the first `BEHIND` metres before the first lane's begin."""
        shapes = [self._town.lanes[lane].points[:, :2] for lane in lanes]
        if not shapes:
            return np.zeros((2, 3))
        points = _without_repeats(np.concatenate(shapes))
        tail = self._tail(behind, points)
        line = _without_repeats(np.concatenate((tail, points)))
        along = arc_lengths(line)
        start = along[len(tail)] - BEHIND
        at = start + np.arange(0.0, max(along[-1] - start, PATH_STEP), PATH_STEP)
        x, y = np.interp(at, along, line[:, 0]), np.interp(at, along, line[:, 1])
        # A vehicle's body is a chord of its path: its heading is that between rear and front.
        ahead, back = at + 2.0, at - 2.0
        dx = np.interp(ahead, along, line[:, 0]) - np.interp(back, along, line[:, 0])
        dy = np.interp(ahead, along, line[:, 1]) - np.interp(back, along, line[:, 1])
        return np.stack((x, y, np.arctan2(dy, dx)), axis=1)

    def _tail(
        self, behind: str | None, points: Float[np.ndarray, "points 2"]
    ) -> Float[np.ndarray, "tail 2"]:
        direction = points[1] - points[0]
        direction = direction / max(float(np.hypot(*direction)), 1e-6)
        straight = points[0] - (BEHIND + 4.0) * direction
        if behind is None or behind not in self._town.lanes:
            return straight[None]
        shape = self._town.lanes[behind].points[:, :2]
        shape = shape[np.hypot(*(shape - points[0]).T) > 0.2]
        if len(shape) < 2:
            return straight[None]
        along = arc_lengths(shape)
        begin = shape[0] + (shape[0] - shape[1]) / max(along[1], 1e-6) * (BEHIND + 4.0)
        return np.concatenate((begin[None], shape))

    def _stop(self, state: VehicleState, lanes: list[str], links: list[NextLink]) -> float:
        """Return the arc length from the present lane's begin at which the front must stop."""
        lane = self._town.lanes.get(state.lane)
        if lane is None or not links:
            return math.inf
        along, place = lane.length, 1
        for link in links:
            if not link.open and not (link.via == state.lane):
                return along
            while place < len(lanes):
                along += self._town.lanes[lanes[place]].length
                place += 1
                if lanes[place - 1] == link.target:
                    break
        return math.inf


def _without_repeats(points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "kept 2"]:
    steps = np.hypot(*np.diff(points, axis=0).T)
    return points[np.concatenate(([True], steps > 1e-3))]


def _ahead(poses: Float[np.ndarray, "samples 3"], at: float) -> Float[np.ndarray, "steps 3"]:
    """Return `PATH_POSES` poses from an arc length (of the first lane) on, the last one repeated."""
    index, share = divmod((at + BEHIND) / PATH_STEP, 1.0)
    first = min(max(int(index), 0), len(poses) - 2)
    piece = poses[first : first + PATH_POSES + 1]
    moved = piece[:-1, :2] + share * (piece[1:, :2] - piece[:-1, :2])
    out = np.empty((PATH_POSES, 3))
    count = min(len(moved), PATH_POSES)
    out[:count, :2] = moved[:count]
    out[:count, 2] = piece[:count, 2]
    out[count:] = out[count - 1]
    return out


def _shift(
    path: Float[np.ndarray, "steps 3"],
    pose: Float[np.ndarray, " 3"],
    state: VehicleState,
    lane: Lane | None,
) -> None:
    """Bend a path, in place, to where a vehicle that is changing lanes will come out."""
    left = -math.sin(path[0, 2]), math.cos(path[0, 2])
    offset = (pose[0] - path[0, 0]) * left[0] + (pose[1] - path[0, 1]) * left[1]
    width = lane.width if lane else 3.2
    leaving = offset * state.lateral > 0.0
    final = math.copysign(width, state.lateral) if leaving else 0.0
    duration = abs(final - offset) / abs(state.lateral)
    reach = max(state.speed * duration, 1.0)
    share = np.minimum(np.arange(len(path)) * PATH_STEP / reach, 1.0)
    aside = offset + share * (final - offset)
    path[:, 0] -= np.sin(path[:, 2]) * aside
    path[:, 1] += np.cos(path[:, 2]) * aside
