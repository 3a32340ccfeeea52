"""Finds the places on a route where each kind of hazard can happen.

The table's `where` names one of the finders here. A finder is given the kinds that share it, and
asks what their `fits` name.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from plant_bench.towns.hazard_track import MARGIN, MERGE_RUN, Track
from plant_bench.world.conflicting_paths import approaches
from plant_bench.world.driver_braking import BRAKING, GRIP, REACTION
from plant_bench.world.hazard import HazardKind
from plant_bench.world.hazard_table import HAZARDS, load_part
from plant_bench.world.route import Route
from plant_bench.world.town import Lane, Town

CROSSED_LIMIT = 14.0  # m/s: no crossings on faster roads
ROOM = 60.0  # m of lane that lane events need
RUN, LINE_RUN = 60.0, 30.0  # m of approach of a conflicting vehicle, to the junction and its line
UNSEEN = 100.0  # m in a straight line, for those put out beyond the ego's sight


@dataclass(frozen=True)
class Place:
    """Where a hazard can happen.

    Attributes:
        kind: What.
        at: Arc length, metres.
        limit: The ego's speed limit there, m/s.
        arm: Arc length from which on it may begin, metres.
        room: Metres of the same lane ahead.
        sides: Sides for crossing actors: 1 from the left, -1 from the right.
        parameters: What the place dictates.
    """

    kind: HazardKind
    at: float
    limit: float
    arm: float = 0.0
    room: float = 0.0
    sides: tuple[int, ...] = (-1,)
    parameters: dict[str, float] = field(default_factory=dict)


def possible_places(town: Town, route: Route) -> list[Place]:
    """Return all places of a route where a hazard can happen, of all kinds."""
    track = Track(town, route)
    sharing: dict[str, list[HazardKind]] = {}
    for kind, row in HAZARDS.items():
        sharing.setdefault(row.where, []).append(kind)
    found = [
        place for kinds in sharing.values() for place in load_part(kinds[0], "where")(track, kinds)
    ]
    inner = (place for place in found if MARGIN < place.at < route.length - MARGIN)
    armed = ((place, _arm(track, place)) for place in inner)
    return [replace(place, arm=arm) for place, arm in armed if arm is not None]


def _arm(track: Track, place: Place) -> float | None:
    """Return where a place's hazard may begin, None where the route has not the metres it needs."""
    need = HAZARDS[place.kind].arm
    arm = place.at - min(max(need.nearest, need.time * place.limit), need.farthest)
    if not need.whole:
        return max(arm, 0.0)
    if need.unseen:
        while arm > place.at - need.farthest and track.apart(arm, place.at) < UNSEEN:
            arm -= 5.0
        if track.apart(max(arm, 0.0), place.at) < UNSEEN:
            return None
    return arm if arm >= 0.0 else None


def off_junctions(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find where a driver with little grip need not stop, and keeps its lane."""
    for at in track.places:
        limit, (before, after) = track.limit(at), track.room(at)
        slides = 2.5 * limit
        stops = REACTION * limit + limit**2 / (2.0 * GRIP * BRAKING)
        ample = after > max(slides, stops) + 10.0
        if before > 10.0 and ample and track.keeps_lane(at - 10.0, at + slides):
            for kind in kinds:
                yield Place(kind, at, limit)


def at_kerbs(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find where one may step onto a street between junctions."""
    sides: dict[str, tuple[int, ...]] = {}
    for at in track.places:
        lane, (before, after) = track.lane(at), track.room(at)
        slow = lane.speed_limit < CROSSED_LIMIT and track.is_kerb(lane)
        if slow and before > 20.0 and after > 15.0 and track.keeps_lane(at - 10.0, at + 10.0):
            known = sides.setdefault(lane.id, track.sides(lane))
            for kind in kinds:
                yield Place(kind, at, track.limit(at), sides=known)


def behind_turns(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find where one may step onto a street that the ego turns into."""
    for passage in track.route.passages:
        at = passage.exit + 6.0  # give or take two metres
        lane = track.lane(at)
        slow = lane.speed_limit < CROSSED_LIMIT and track.is_kerb(lane)
        if passage.turn != "straight" and slow and track.room(at)[1] > 12.0:
            sides = track.sides(lane)
            for kind in kinds:
                yield Place(kind, at, track.limit(at), sides=sides)


def at_junctions(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find junctions with a long enough conflicting approach; `fits` gets approach and passage."""
    known = [(kind, load_part(kind, "fits")) for kind in kinds]
    for passage in track.route.passages:
        at = 0.5 * (passage.entry + passage.exit)
        ways = approaches(track.town, track.route, passage)
        for kind, fits in known:
            runs = (way for way in ways if fits(way, passage))
            if any(way.meets > RUN and way.stop > LINE_RUN for way in runs):
                yield Place(kind, at, track.limit(at))


@dataclass(frozen=True)
class Stretch:
    """A stretch of a lane that the ego keeps, around a place.

    Attributes:
        track: What lies along the route.
        at: Arc length of the place, metres.
        lane: The lane.
        limit: The ego's speed limit, m/s.
        before: Metres to the junction behind.
        after: Metres to the junction ahead.
        room: Metres of the same lane ahead.
        straight: Whether it leads straight on.
    """

    track: Track
    at: float
    lane: Lane
    limit: float
    before: float
    after: float
    room: float
    straight: bool


def on_lanes(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find where something may happen on the ego's lane.

    `fits` is given a `Stretch`, and returns the parameters of each hazard that can happen there.
    """
    known = [(kind, load_part(kind, "fits")) for kind in kinds]
    for at in track.places:
        lane, (before, after) = track.lane(at), track.room(at)
        if lane.junction is not None or not track.keeps_lane(at - ROOM, at + 0.5 * ROOM):
            continue
        straight = track.is_straight(at - 0.5 * ROOM, at + 0.5 * ROOM)
        limit, room = track.limit(at), track.span(at).end - at
        stretch = Stretch(track, at, lane, limit, before, after, room, straight)
        for kind, fits in known:
            for parameters in fits(stretch):
                yield Place(kind, at, limit, room=room, parameters=parameters)


def for_braking(stretch: Stretch) -> list[dict[str, float]]:
    """Tell whether there is space for a braking leader and the ego behind it."""
    return [{}] if stretch.before > 0.5 * ROOM and stretch.after > 0.5 * ROOM else []


def for_cutting_in(stretch: Stretch) -> list[dict[str, float]]:
    """Have a lane beside a straight stretch; one place for each side."""
    if not (stretch.straight and stretch.before > ROOM and stretch.after > 0.5 * ROOM):
        return []
    lanes, sides = stretch.track.town.lanes, ((-1.0, stretch.lane.right), (1.0, stretch.lane.left))
    return [{"side": side} for side, name in sides if name and not lanes[name].acceleration]


def for_blocking(stretch: Stretch) -> list[dict[str, float]]:
    """Have a kerb on a straight stretch, and a lane by which one could pass."""
    track, at, lane = stretch.track, stretch.at, stretch.lane
    slow = stretch.limit < CROSSED_LIMIT
    passable = lane.left is not None or (slow and track.has_oncoming(lane))
    roomy = stretch.before > ROOM and stretch.after > ROOM
    keeps = roomy and track.keeps_lane(at - ROOM, at + ROOM)
    return [{}] if stretch.straight and keeps and track.is_kerb(lane) and passable else []


def for_queues(stretch: Stretch) -> list[dict[str, float]]:
    """Tell whether there is space on the same lane for stationary vehicles."""
    ample = min(stretch.after, stretch.room) > 0.5 * ROOM
    return [{}] if stretch.before > ROOM and ample else []


def at_lane_changes(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find where one can come from afar on the lane that the ego changes to."""
    for change in track.route.lane_changes:
        at = 0.5 * (change.start + change.end)
        side = 1.0 if change.direction == "left" else -1.0
        beyond = next((span.start for span in track.route.lanes if span.start >= at), None)
        if beyond is not None and track.run_to(beyond) > MERGE_RUN:
            for kind in kinds:
                yield Place(kind, at, track.limit(at), parameters={"side": side})
