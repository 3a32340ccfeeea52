"""Finds the places on a route where each kind of hazard can happen.

The `where` of the hazard table names a finder in this module. A finder gets the kinds of hazard
that share it; their `fits` name functions that decide whether a place suits a kind.
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
ROOM = 60.0  # m of lane that hazards between junctions need
RUN, LINE_RUN = 60.0, 30.0  # m of a conflicting vehicle's approach to conflict and stop line
UNSEEN = 100.0  # m in a straight line: minimum distance of actors placed out of the ego's sight


@dataclass(frozen=True)
class Place:
    """A place where a hazard can happen.

    Attributes:
        kind: The kind of hazard.
        at: Arc length, metres.
        limit: The ego's speed limit there, m/s.
        arm: Arc length from which the hazard may begin, metres.
        lane_ahead: Remaining length of the same lane, metres.
        sides: Sides from which actors can cross: 1 for left, -1 for right.
        parameters: Parameters that the place determines.
    """

    kind: HazardKind
    at: float
    limit: float
    arm: float = 0.0
    lane_ahead: float = 0.0
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
    """Return the arc length from which a hazard may begin; None if the route is too short."""
    need = HAZARDS[place.kind].arm
    arm = place.at - min(max(need.nearest, need.time * place.limit), need.farthest)
    if not need.whole:
        return max(arm, 0.0)
    if need.unseen:
        while arm > place.at - need.farthest and track.distance_between(arm, place.at) < UNSEEN:
            arm -= 5.0
        if track.distance_between(max(arm, 0.0), place.at) < UNSEEN:
            return None
    return arm if arm >= 0.0 else None


def off_junctions(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find places far from junctions and lane changes, so that a loss of grip is survivable."""
    for at in track.places:
        limit, (before, after) = track.limit(at), track.junction_distances(at)
        slides = 2.5 * limit
        stops = REACTION * limit + limit**2 / (2.0 * GRIP * BRAKING)
        enough = after > max(slides, stops) + 10.0
        if before > 10.0 and enough and track.keeps_lane(at - 10.0, at + slides):
            for kind in kinds:
                yield Place(kind, at, limit)


def at_kerbs(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find places between junctions where a pedestrian may step onto the street."""
    sides: dict[str, tuple[int, ...]] = {}
    for at in track.places:
        lane, (before, after) = track.lane(at), track.junction_distances(at)
        slow = lane.speed_limit < CROSSED_LIMIT and track.is_kerb(lane)
        if slow and before > 20.0 and after > 15.0 and track.keeps_lane(at - 10.0, at + 10.0):
            known = sides.setdefault(lane.id, track.sides(lane))
            for kind in kinds:
                yield Place(kind, at, track.limit(at), sides=known)


def behind_turns(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find places where a pedestrian may step onto a street that the ego turns into."""
    for passage in track.route.passages:
        at = passage.exit + 6.0  # plus or minus two metres (`spread` in the hazard table)
        lane = track.lane(at)
        slow = lane.speed_limit < CROSSED_LIMIT and track.is_kerb(lane)
        if passage.turn != "straight" and slow and track.junction_distances(at)[1] > 12.0:
            sides = track.sides(lane)
            for kind in kinds:
                yield Place(kind, at, track.limit(at), sides=sides)


def at_junctions(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find junctions with a long enough conflicting approach.

    `fits` gets the approach and the passage.
    """
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
    """A stretch of lane around a place, without lane changes of the ego.

    Attributes:
        track: The lanes and junctions along the route.
        at: Arc length of the place, metres.
        lane: The lane.
        limit: The ego's speed limit, m/s.
        before: Distance to the previous junction, metres.
        after: Distance to the next junction, metres.
        lane_ahead: Remaining length of the same lane, metres.
        straight: Whether the stretch is straight.
    """

    track: Track
    at: float
    lane: Lane
    limit: float
    before: float
    after: float
    lane_ahead: float
    straight: bool


def on_lanes(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find places between junctions for hazards on the ego's lane.

    `fits` gets a `Stretch`, and returns the parameters of each hazard that can happen there.
    """
    known = [(kind, load_part(kind, "fits")) for kind in kinds]
    for at in track.places:
        lane, (before, after) = track.lane(at), track.junction_distances(at)
        if lane.junction is not None or not track.keeps_lane(at - ROOM, at + 0.5 * ROOM):
            continue
        straight = track.is_straight(at - 0.5 * ROOM, at + 0.5 * ROOM)
        limit, lane_ahead = track.limit(at), track.span(at).end - at
        stretch = Stretch(track, at, lane, limit, before, after, lane_ahead, straight)
        for kind, fits in known:
            for parameters in fits(stretch):
                yield Place(kind, at, limit, lane_ahead=lane_ahead, parameters=parameters)


def for_braking(stretch: Stretch) -> list[dict[str, float]]:
    """Accept a stretch with space for a braking leader and the ego behind it."""
    return [{}] if stretch.before > 0.5 * ROOM and stretch.after > 0.5 * ROOM else []


def for_cutting_in(stretch: Stretch) -> list[dict[str, float]]:
    """Accept a straight stretch with an adjacent lane; one hazard per side that has one."""
    if not (stretch.straight and stretch.before > ROOM and stretch.after > 0.5 * ROOM):
        return []
    lanes, sides = stretch.track.town.lanes, ((-1.0, stretch.lane.right), (1.0, stretch.lane.left))
    return [{"side": side} for side, name in sides if name and not lanes[name].acceleration]


def for_blocking(stretch: Stretch) -> list[dict[str, float]]:
    """Accept a straight stretch beside a kerb, with a second lane on which the ego could pass."""
    track, at, lane = stretch.track, stretch.at, stretch.lane
    slow = stretch.limit < CROSSED_LIMIT
    passable = lane.left is not None or (slow and track.has_oncoming(lane))
    far_from_junctions = stretch.before > ROOM and stretch.after > ROOM
    keeps = far_from_junctions and track.keeps_lane(at - ROOM, at + ROOM)
    return [{}] if stretch.straight and keeps and track.is_kerb(lane) and passable else []


def for_queues(stretch: Stretch) -> list[dict[str, float]]:
    """Accept a stretch with space on its lane for a queue of vehicles."""
    enough = min(stretch.after, stretch.lane_ahead) > 0.5 * ROOM
    return [{}] if stretch.before > ROOM and enough else []


def at_lane_changes(track: Track, kinds: Sequence[HazardKind]) -> Iterator[Place]:
    """Find lane changes onto a lane on which a vehicle can approach from far behind."""
    for change in track.route.lane_changes:
        at = 0.5 * (change.start + change.end)
        side = 1.0 if change.direction == "left" else -1.0
        beyond = next((span.start for span in track.route.lanes if span.start >= at), None)
        if beyond is not None and track.approach_length(beyond) > MERGE_RUN:
            for kind in kinds:
                yield Place(kind, at, track.limit(at), parameters={"side": side})
