"""True future paths of the background vehicles along their lanes, as privileged facts."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from plant_bench.agent import PATH_POSES, PATH_STEP, Privileged
from plant_bench.geometry.polyline import arc_lengths, without_repeats
from plant_bench.sim.sumo import NextLink, Sumo, VehicleState
from plant_bench.world.scene import TICK, Actors
from plant_bench.world.town import Lane, Town

REFRESH = 4  # ticks between two queries of right of way: the drivers' own action step
RETRACE = 20  # ticks between two queries of a vehicle's path on the same lane
BEHIND = 8.0  # m of path kept before the lane's start, for a vehicle's rear
STRETCH = 200.0  # m: longer lanes are divided into stretches of this length
FINENESS = 2  # samples stored per pose: accuracy 0.25 m
REACH = PATH_POSES * PATH_STEP  # m of path ahead, at least
PATH_SAMPLES = FINENESS * int((BEHIND + STRETCH + REACH) / PATH_STEP + 2.0)
LANE_CHANGE_SPEED = 0.05  # m/s of lateral speed above which a vehicle is changing lanes
STOPPED = 0.1  # m/s


@dataclass(slots=True)
class _Track:
    """Cached data of one vehicle; mutable."""

    lane: str
    stretch: int
    factor: float
    path: int = 0
    stop: float = math.inf
    refreshed: int = 0
    traced: int = 0
    link_ends: list[float] = field(default_factory=list)
    behind: str | None = None
    stopped_since: int | None = None

    def holds(self, tick: int, lane: str, stretch: int) -> bool:
        """Tell whether the cached data is still valid."""
        return (
            tick - self.refreshed < REFRESH
            and self.lane == lane
            and self.stretch == stretch
            and tick - self.traced < RETRACE
        )


class LanePaths:
    """Computes the privileged facts of the watched vehicles; mutable.

    Paths are cached by their lanes, because many vehicles share them.

    Args:
        sumo: The running simulation.
        town: The town's lanes.
    """

    def __init__(self, sumo: Sumo, town: Town) -> None:
        self._sumo = sumo
        self._town = town
        self._tracks: dict[int, _Track] = {}
        self._scales: dict[str, float] = {}
        self._known: dict[tuple[str | None, tuple[str, ...], int], int] = {}
        self._paths = np.empty((64, PATH_SAMPLES, 3))

    def facts(
        self,
        tick: int,
        actors: Actors,
        states: dict[int, VehicleState],
        scripted: Mapping[int, Float[np.ndarray, "steps 3"]],
    ) -> Privileged:
        """Return the facts of the vehicles of one scene, in their order.

        Args:
            tick: Tick of the scene.
            actors: Actors of the scene, those of `states` first.
            states: Vehicle states from SUMO.
            scripted: Paths of actors that a hazard moves.
        """
        count = len(states)
        which, at = [0] * count, [0.0] * count
        stops, limits, waited = [0.0] * count, [0.0] * count, [0.0] * count
        half_lengths = (0.5 * actors.extents[:, 0]).tolist()
        changing: list[tuple[int, VehicleState]] = []
        lanes = self._town.lanes
        tracks, scales = self._tracks, self._scales
        for row, (vehicle, state) in enumerate(states.items()):
            lane = lanes.get(state.lane)
            scale = scales.get(state.lane)
            front = state.lane_position * (self._scale(state.lane) if scale is None else scale)
            track, stretch = tracks.get(vehicle), int(front / STRETCH)
            if track is None or not track.holds(tick, state.lane, stretch):
                track = self._track(tick, vehicle, state, stretch)
            which[row] = track.path
            at[row] = front % STRETCH - half_lengths[row]
            stops[row] = track.stop - front
            limits[row] = track.factor * (lane.speed_limit if lane else state.speed)
            if state.speed < STOPPED or track.stopped_since is not None:
                waited[row] = self._waited(tick, track, state)
            if abs(state.lateral) > LANE_CHANGE_SPEED:
                changing.append((row, state))
        paths = _ahead(self._paths, np.array(which, np.intp), np.array(at))
        for row, state in changing:
            _shift(paths[row], actors.poses[row], state, lanes.get(state.lane))
        for row, vehicle in enumerate(states):
            if vehicle in scripted:
                paths[row] = scripted[vehicle]
                stops[row], limits[row] = math.inf, states[vehicle].speed
        self._forget(tick)
        return Privileged(
            paths=paths,
            accelerations=np.array([state.acceleration for state in states.values()]),
            desired_speeds=np.array(limits),
            stop_distances=np.array(stops),
            stopped_for=np.array(waited),
        )

    def _scale(self, name: str) -> float:
        """Return the ratio of a lane's length in the town to that in SUMO."""
        lane = self._town.lanes.get(name)
        scale = lane.length / self._sumo.lane_length(name) if lane else 1.0
        self._scales[name] = scale
        return scale

    def _track(self, tick: int, vehicle: int, state: VehicleState, stretch: int) -> _Track:
        track = self._tracks.get(vehicle)
        if track is None:
            factor = self._sumo.desired_speed_factor(vehicle)
            track = self._tracks[vehicle] = _Track(state.lane, stretch, factor)
            self._trace(tick, vehicle, track)
        elif track.lane != state.lane:
            track.behind = track.lane if state.lane in self._successors(track.lane) else None
            track.lane, track.stretch = state.lane, stretch
            self._trace(tick, vehicle, track)
        elif track.stretch != stretch or tick - track.traced >= RETRACE:
            track.stretch = stretch
            self._trace(tick, vehicle, track)
        elif tick - track.refreshed >= REFRESH:
            self._refresh(tick, vehicle, track)
        return track

    def _trace(self, tick: int, vehicle: int, track: _Track) -> None:
        """Query a vehicle's path."""
        links = self._sumo.next_links(vehicle)
        lanes, track.link_ends = self._lanes(track.lane, links)
        track.path = self._path(track.behind, lanes, track.stretch)
        track.traced = tick
        closed = next((place for place, link in enumerate(links) if not link.open), -1)
        self._update_stop(tick, track, closed)

    def _refresh(self, tick: int, vehicle: int, track: _Track) -> None:
        """Query where a vehicle must stop."""
        self._update_stop(tick, track, self._sumo.closed_link(vehicle))

    @staticmethod
    def _update_stop(tick: int, track: _Track, closed: int) -> None:
        known = 0 <= closed < len(track.link_ends)
        track.stop = track.link_ends[closed] if known else math.inf
        track.refreshed = tick

    def _path(self, behind: str | None, lanes: tuple[str, ...], stretch: int) -> int:
        """Return the index of the path along some lanes, computing it if it is new."""
        index = self._known.get((behind, lanes, stretch))
        if index is None:
            index = self._known[behind, lanes, stretch] = len(self._known)
            if index == len(self._paths):
                self._paths = np.concatenate((self._paths, np.empty_like(self._paths)))
            self._paths[index] = self._poses(behind, lanes, stretch * STRETCH)
        return index

    def _forget(self, tick: int) -> None:
        if tick % 100 == 0:
            fresh = {
                key: track for key, track in self._tracks.items() if tick - track.refreshed < 100
            }
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

    def _lanes(self, first: str, links: list[NextLink]) -> tuple[tuple[str, ...], list[float]]:
        """Return the lanes ahead, current one first, and the position of each stop line."""
        known = self._town.lanes
        lanes, ends = [first], []
        along = known[first].length if first in known else 0.0
        reach = along + REACH
        for link in links:
            ends.append(along)
            onward = [lane for lane in self._through(lanes[-1], link) if lane in known]
            lanes += onward
            along += sum(known[lane].length for lane in onward)
            if along > reach:
                break
        while along < reach:
            successors = self._successors(lanes[-1])
            if not successors:
                break
            lanes.append(successors[0])
            along += known[successors[0]].length
        return tuple(lane for lane in lanes if lane in known), ends

    def _through(self, source: str, link: NextLink) -> list[str]:
        inner: list[str] = []
        lane = link.via
        while lane and lane != link.target and len(inner) < 8:
            if lane != source:
                inner.append(lane)
            lane = next(iter(self._successors(lane)), "")
        return [*inner, link.target]

    def _poses(
        self, behind: str | None, lanes: tuple[str, ...], begin: float
    ) -> Float[np.ndarray, "samples 3"]:
        """Return poses from `BEHIND` metres before `begin` (of the first lane) on."""
        if not lanes:
            return np.zeros((PATH_SAMPLES, 3))
        shapes = [self._town.lanes[lane].points[:, :2] for lane in lanes]
        points = without_repeats(np.concatenate(shapes))
        tail = self._tail(behind, points)
        line = without_repeats(np.concatenate((tail, points)))
        along = arc_lengths(line)
        start = along[len(tail)] + begin - BEHIND
        at = start + PATH_STEP / FINENESS * np.arange(PATH_SAMPLES)
        x, y = np.interp(at, along, line[:, 0]), np.interp(at, along, line[:, 1])
        # A vehicle's body is a chord of its path: its heading is that between rear and front.
        ahead, back = np.minimum(at, along[-1]) + 2.0, np.minimum(at, along[-1]) - 2.0
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


def _ahead(
    paths: Float[np.ndarray, "paths samples 3"],
    which: Int[np.ndarray, " actors"],
    at: Float[np.ndarray, " actors"],
) -> Float[np.ndarray, "actors steps 3"]:
    """Return `PATH_POSES` poses from an arc length (of the first lane) on, for each actor."""
    most = PATH_SAMPLES - FINENESS * PATH_POSES
    place = np.clip((at + BEHIND) * (FINENESS / PATH_STEP) + 0.5, 0.0, most)
    first = place.astype(np.intp) + which * PATH_SAMPLES
    return paths.reshape(-1, 3).take(first[:, None] + FINENESS * np.arange(PATH_POSES), axis=0)


def _shift(
    path: Float[np.ndarray, "steps 3"],
    pose: Float[np.ndarray, " 3"],
    state: VehicleState,
    lane: Lane | None,
) -> None:
    """Shift a path, in place, to the target lane of a vehicle that is changing lanes."""
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
