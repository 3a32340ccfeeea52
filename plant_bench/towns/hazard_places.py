"""Where on a route each kind of hazard can happen."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.world.approaches import FITS, approaches
from plant_bench.world.hazard import HazardKind
from plant_bench.world.route import LaneSpan, Route
from plant_bench.world.town import Lane, Town

STEP = 5  # m between places looked at
MARGIN = 40.0  # m at the route's two ends without hazards
CROSSED_LIMIT = 14.0  # m/s: nobody walks across faster roads
STRAIGHT = 0.12  # rad that a lane may turn over the metres a lane event takes
ROOM = 60.0  # m of lane that lane events need
FAR = 1e6  # m to a junction that is not there
RUN, LINE_RUN = 60.0, 30.0  # m that who meets the ego in a junction comes, to it and to its line
MERGE_RUN = 150.0  # m that who is beside the ego comes straight on
SLIPPERY = 2.4  # m/s2 of braking that control losses leave
# m before the place at which a kind may begin: this time at the speed limit, at least, at most.
ARMS = {
    HazardKind.HARD_BRAKE: (11.0, 130.0, 220.0),  # a leader is sent 90 m ahead, and waits
    HazardKind.CUT_IN: (11.0, 130.0, 220.0),
    HazardKind.MERGE_PRESSURE: (9.0, 100.0, 180.0),  # vehicles get into place beside the ego
    HazardKind.BLOCKED_LANE: (12.0, 140.0, 240.0),  # put out beyond the ego's sight
    HazardKind.QUEUE_TAIL: (12.0, 140.0, 240.0),
}
ARM = (10.0, 90.0, 140.0)  # all others, cut off at the start of the route
UNSEEN = 100.0  # m in a straight line, for those put out beyond the ego's sight
OPPOSITE = 2.4  # rad between the headings of two neighbour lanes that lead opposite ways


@dataclass(frozen=True)
class Place:
    """Where a hazard can happen.

    Attributes:
        kind: What.
        at: Arc length, metres.
        limit: The ego's speed limit there, m/s.
        arm: Arc length from which on it may begin, metres.
        room: Metres of the same lane ahead.
        sides: For who crosses: 1 from the left, -1 from the right.
        parameters: What the place dictates.
    """

    kind: HazardKind
    at: float
    limit: float
    arm: float = 0.0
    room: float = 0.0
    sides: tuple[int, ...] = (-1,)
    parameters: dict[str, float] = field(default_factory=dict)


class Track:
    """What lies along a route, metre by metre; immutable."""

    def __init__(self, town: Town, route: Route) -> None:
        self.town = town
        self.route = route
        metres = np.arange(int(route.length) + 1)
        before, after = np.full(len(metres), FAR), np.full(len(metres), FAR)
        for passage in route.passages:
            gone, left = metres - passage.exit, passage.entry - metres
            before = np.where(gone >= 0.0, np.minimum(before, gone), before)
            after = np.where(left >= 0.0, np.minimum(after, left), after)
            inside = (metres > passage.entry) & (metres < passage.exit)
            before[inside] = after[inside] = 0.0
        self._before, self._after = before, after
        self._oncoming: dict[str, bool] = {}

    @property
    def places(self) -> list[float]:
        """The metres to look at, the route's ends left out."""
        return [
            float(at) for at in range(int(MARGIN) + STEP, int(self.route.length - MARGIN), STEP)
        ]

    def room(self, at: float) -> tuple[float, float]:
        """Return the metres to the junction behind and to the one ahead."""
        return float(self._before[int(at)]), float(self._after[int(at)])

    def limit(self, at: float) -> float:
        """Return the ego's speed limit, m/s."""
        return float(np.interp(at, self.route.along, self.route.speed_limits))

    def apart(self, one: float, other: float) -> float:
        """Return how far two places of the route are apart in a straight line, metres."""
        route = self.route
        x, y = (np.interp((one, other), route.along, column) for column in route.points.T)
        return float(np.hypot(x[1] - x[0], y[1] - y[0]))

    def span(self, at: float) -> LaneSpan:
        """Return the stretch of lane."""
        spans = self.route.lanes
        return next((span for span in spans if span.start <= at < span.end), spans[-1])

    def lane(self, at: float) -> Lane:
        """Return the lane."""
        return self.town.lanes[self.span(at).lane]

    def keeps_lane(self, start: float, end: float) -> bool:
        """Tell whether the route changes no lane on a stretch."""
        changes = self.route.lane_changes
        return all(change.end < start or change.start > end for change in changes)

    def is_straight(self, start: float, end: float) -> bool:
        """Tell whether the route goes straight on on a stretch."""
        route = self.route
        part = route.headings[(route.along >= start) & (route.along <= end)]
        return bool(len(part)) and float(part.max() - part.min()) < STRAIGHT

    def is_kerb(self, lane: Lane) -> bool:
        """Tell whether a lane is the rightmost of its road."""
        return lane.junction is None and lane.right is None and not lane.acceleration

    def sides(self, lane: Lane) -> tuple[int, ...]:
        """Return the sides from which one may step out: the left one across one lane at most."""
        alone = lane.left is None and not self._on_ring(lane)
        return (-1, 1) if alone and self.has_oncoming(lane) else (-1,)

    def has_oncoming(self, lane: Lane) -> bool:
        """Tell whether exactly one lane leads the other way beside a lane."""
        if lane.id not in self._oncoming:
            self._oncoming[lane.id] = self._count_oncoming(lane) == 1
        return self._oncoming[lane.id]

    def _count_oncoming(self, lane: Lane) -> int:
        x, y, heading = _pose(lane, 0.5 * lane.length)
        beside = 0
        for other, middle in self._middles:
            if np.hypot(*(middle - (x, y))) < lane.length:
                ox, oy, back = _nearest_pose(other, x, y)
                left = (oy - y) * np.cos(heading) - (ox - x) * np.sin(heading)
                beside += 0.0 < left < 8.0 and _between(heading, back) > OPPOSITE
        return int(beside)

    def run_to(self, at: float) -> float:
        """Return the metres that the lane at an arc length leads there straight on, from before."""
        lane = self.lane(at)
        x, y = (float(np.interp(at, self.route.along, column)) for column in self.route.points.T)
        apart = np.hypot(lane.points[:, 0] - x, lane.points[:, 1] - y)
        run = float(lane.along[apart.argmin()])
        while run < MERGE_RUN and (before := self._before_straight(lane)) is not None:
            lane, via = before
            run += lane.length + via
        return run

    def _before_straight(self, lane: Lane) -> tuple[Lane, float] | None:
        for link in self.town.links:
            if link.target == lane.id and link.turn == "straight":
                via = sum(self.town.lanes[name].length for name in link.via)
                return self.town.lanes[link.source], via
        return None

    @cached_property
    def _middles(self) -> list[tuple[Lane, np.ndarray]]:
        lanes = [lane for lane in self.town.lanes.values() if lane.junction is None]
        return [(lane, lane.points[len(lane.points) // 2, :2]) for lane in lanes]

    def _on_ring(self, lane: Lane) -> bool:
        return any(lane.edge in ring for ring in self.town.roundabouts)


def _between(one: float, other: float) -> float:
    return abs(wrap_angle(one - other))


def _pose(lane: Lane, at: float) -> tuple[float, float, float]:
    x, y = (np.interp((at, at + 1.0), lane.along, column) for column in lane.points.T[:2])
    return float(x[0]), float(y[0]), float(np.arctan2(y[1] - y[0], x[1] - x[0]))


def _nearest_pose(lane: Lane, x: float, y: float) -> tuple[float, float, float]:
    at = np.arange(0.0, lane.length, 1.0)
    px, py = (np.interp(at, lane.along, column) for column in lane.points.T[:2])
    best = int(np.argmin(np.hypot(px - x, py - y)))
    return _pose(lane, float(at[best]))


def possible_places(town: Town, route: Route) -> list[Place]:
    """Return all places of a route where a hazard can happen, of all kinds."""
    track = Track(town, route)
    found = [place for finder in _FINDERS for place in finder(track)]
    inner = (place for place in found if MARGIN < place.at < route.length - MARGIN)
    armed = ((place, _arm(track, place)) for place in inner)
    return [replace(place, arm=arm) for place, arm in armed if arm is not None]


def _arm(track: Track, place: Place) -> float | None:
    """Return where a place's hazard may begin, None where the route has not the metres it needs."""
    time, nearest, farthest = ARMS.get(place.kind, ARM)
    arm = place.at - min(max(nearest, time * place.limit), farthest)
    if place.kind not in ARMS:
        return max(arm, 0.0)
    if place.kind in (HazardKind.BLOCKED_LANE, HazardKind.QUEUE_TAIL):
        while arm > place.at - farthest and track.apart(arm, place.at) < UNSEEN:
            arm -= 5.0
        if track.apart(max(arm, 0.0), place.at) < UNSEEN:
            return None
    return arm if arm >= 0.0 else None


def _control_losses(track: Track) -> Iterator[Place]:
    for at in track.places:
        limit, (before, after) = track.limit(at), track.room(at)
        slides = 2.5 * limit
        stops = 0.5 * limit + limit**2 / (2.0 * SLIPPERY)
        ample = after > max(slides, stops) + 10.0
        if before > 10.0 and ample and track.keeps_lane(at - 10.0, at + slides):
            yield Place(HazardKind.CONTROL_LOSS, at, limit)


def _crossings(track: Track) -> Iterator[Place]:
    sides: dict[str, tuple[int, ...]] = {}
    for at in track.places:
        lane, (before, after) = track.lane(at), track.room(at)
        slow = lane.speed_limit < CROSSED_LIMIT and track.is_kerb(lane)
        if slow and before > 20.0 and after > 15.0 and track.keeps_lane(at - 10.0, at + 10.0):
            known = sides.setdefault(lane.id, track.sides(lane))
            yield Place(HazardKind.CROSSING, at, track.limit(at), sides=known)


def _crossings_after_turns(track: Track) -> Iterator[Place]:
    for passage in track.route.passages:
        at = passage.exit + 6.0  # give or take two metres
        lane = track.lane(at)
        slow = lane.speed_limit < CROSSED_LIMIT and track.is_kerb(lane)
        if passage.turn != "straight" and slow and track.room(at)[1] > 12.0:
            sides = track.sides(lane)
            yield Place(HazardKind.CROSSING_AFTER_TURN, at, track.limit(at), sides=sides)


def _at_junctions(track: Track) -> Iterator[Place]:
    for passage in track.route.passages:
        at = 0.5 * (passage.entry + passage.exit)
        ways = approaches(track.town, track.route, passage)
        for kind, fits in FITS.items():
            runs = (way for way in ways if fits(way, passage))
            if any(way.meets > RUN and way.stop > LINE_RUN for way in runs):
                yield Place(kind, at, track.limit(at))


def _lane_events(track: Track) -> Iterator[Place]:
    """Hard brakes, cut-ins, blocked lanes and tails of queues."""
    for at in track.places:
        lane, (before, after), limit = track.lane(at), track.room(at), track.limit(at)
        if lane.junction is not None or not track.keeps_lane(at - ROOM, at + 0.5 * ROOM):
            continue
        straight = track.is_straight(at - 0.5 * ROOM, at + 0.5 * ROOM)
        if before > 0.5 * ROOM and after > 0.5 * ROOM:
            yield Place(HazardKind.HARD_BRAKE, at, limit)
        if straight and before > ROOM and after > 0.5 * ROOM:
            for side, beside in ((-1.0, lane.right), (1.0, lane.left)):
                if beside is not None and not track.town.lanes[beside].acceleration:
                    yield Place(HazardKind.CUT_IN, at, limit, parameters={"side": side})
        passable = lane.left is not None or (limit < CROSSED_LIMIT and track.has_oncoming(lane))
        roomy = before > ROOM and after > ROOM and track.keeps_lane(at - ROOM, at + ROOM)
        if straight and roomy and track.is_kerb(lane) and passable:
            yield Place(HazardKind.BLOCKED_LANE, at, limit)
        if before > ROOM and min(after, track.span(at).end - at) > 0.5 * ROOM:
            yield Place(HazardKind.QUEUE_TAIL, at, limit, room=track.span(at).end - at)


def _merges(track: Track) -> Iterator[Place]:
    for change in track.route.lane_changes:
        at = 0.5 * (change.start + change.end)
        side = 1.0 if change.direction == "left" else -1.0
        beyond = next((span.start for span in track.route.lanes if span.start >= at), None)
        if beyond is not None and track.run_to(beyond) > MERGE_RUN:
            parameters = {"side": side}
            yield Place(HazardKind.MERGE_PRESSURE, at, track.limit(at), parameters=parameters)


_FINDERS: tuple[Callable[[Track], Iterator[Place]], ...] = (
    _control_losses,
    _crossings,
    _crossings_after_turns,
    _at_junctions,
    _lane_events,
    _merges,
)
