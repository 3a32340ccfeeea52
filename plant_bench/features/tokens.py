"""PlanT's objects: road users and route segments as tokens of six attributes (PlanT, section 3).

A token is (z, x, y, yaw, width, length) in the ego frame: z is the speed of an actor, or the place
of a route segment in their order. Metres, m/s and radians.
"""

import math
from dataclasses import dataclass, field
from enum import IntEnum
from itertools import pairwise

import numpy as np
import shapely
from jaxtyping import Float, Int, UInt8

from plant_bench.agent import NextLight, RouteAhead
from plant_bench.features.motion import MOTION_ATTRIBUTES, Rates, no_rates
from plant_bench.features.predicted_conflicts import CONFLICT_ATTRIBUTES, predicted_conflicts
from plant_bench.geometry.pose import wrap_angle
from plant_bench.jit import FLAG, FLAGS, REALS, SINGLES, SINGLES_2D, WHOLES, compiled
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, ActorKind, Actors, EgoState, Light

ATTRIBUTES = 6
NOWHERE = -1  # the place among the actors of what is none
STOPS = (Light.RED, Light.YELLOW)
CROSSED = 1.0  # m beyond a stop line from which on it is left behind
LINE_LENGTH = 0.5  # m along the route
LEAST_SQUARE = 1e-6  # m2/s2, of a relative speed

_IS_VULNERABLE = np.array([kind in (ActorKind.PEDESTRIAN, ActorKind.BICYCLE) for kind in ActorKind])


class TokenKind(IntEnum):
    """The object types, each with an embedding of its own."""

    PADDING = 0
    VEHICLE = 1
    ROUTE = 2
    VULNERABLE = 3
    STOP_LINE = 4


@dataclass(frozen=True)
class TokenSpec:
    """What becomes a token.

    Attributes:
        reach: Metres from the ego's centre within which actors count, and within which a route
            segment must start (D_max = 30; PlanT, "Implementation").
        horizon: Seconds; farther actors count, too, that come within the reach in this time if
            they and the ego go on as now. PlanT has none; 30 m are two seconds at 50 km/h.
        segments: Number of route segments (N_s = 2; PlanT, "Implementation").
        longest: Metres at which a segment is split (L_max = 10; PlanT, "Implementation").
        tolerance: Metres of the Ramer-Douglas-Peucker subsampling (0.5; PlanT, dataset.py).
        view: Metres of route looked at (50; PlanT, dataset.py).
        speed: Whether actors' speeds are told (PlanT, table 2).
        rear: Whether actors behind the ego are told (PlanT, table 2).
        vulnerable: Whether walkers and riders are told as a type of their own. PlanT leaves
            walkers out, and riders are vehicles to it.
        stop_line: Whether the line of a red or yellow light is told as a box across the route.
            PlanT is told by its flag that there is one, not where.
        conflicts: Whether actors have four more attributes: where and when they conflict with the
            ego's route under constant motion (`features.predicted_conflicts`). PlanT has none.
        motion: Whether actors have two more attributes, acceleration and turn rate
            (`features.motion`), which predicted conflicts then assume constant. PlanT has none.
    """

    reach: float = 30.0
    horizon: float = field(default=0.0, metadata={"min": 0.0})
    segments: int = field(default=2, metadata={"min": 1})
    longest: float = 10.0
    tolerance: float = 0.5
    view: int = field(default=50, metadata={"min": 10, "max": 100})
    speed: bool = field(default=True, metadata={"option": "speeds"})
    rear: bool = True
    vulnerable: bool = False
    stop_line: bool = False
    conflicts: bool = False
    motion: bool = False

    @property
    def attributes(self) -> int:
        """The number of a token's attributes."""
        return ATTRIBUTES + CONFLICT_ATTRIBUTES * self.conflicts + MOTION_ATTRIBUTES * self.motion


@dataclass(frozen=True, eq=False, slots=True)
class Tokens:
    """The objects of one scene: actors, the nearest first; the route's segments; the stop line.

    Attributes:
        attributes: z, x, y, yaw, width, length; those of `conflicts` and `motion`, 0 for what is no
            actor.
        kinds: `TokenKind` values.
        places: Place in the observation's actors; `NOWHERE` for what is none.
    """

    attributes: Float[np.ndarray, "tokens attributes"]
    kinds: UInt8[np.ndarray, " tokens"]
    places: Int[np.ndarray, " tokens"]

    def __len__(self) -> int:
        return len(self.kinds)


def tokens_of(
    ego: EgoState,
    actors: Actors,
    route: RouteAhead,
    spec: TokenSpec,
    light: NextLight | None = None,
    rates: Rates | None = None,
) -> Tokens:
    """Return the objects of a scene as the planner is told them."""
    if rates is None or not spec.motion:
        rates = no_rates(actors)
    places = _nearest_first(ego, actors, spec)
    segments = route_attributes(ego, route, spec)
    lines = stop_line_attributes(ego, route, light if spec.stop_line else None)
    near, rows = len(places), len(places) + len(segments)
    count = rows + len(lines)
    attributes = np.zeros((count, spec.attributes), np.float32)
    attributes[:near, :ATTRIBUTES] = actor_attributes(ego, actors, places)
    attributes[near:rows, :ATTRIBUTES] = segments
    attributes[rows:, :ATTRIBUTES] = lines
    if spec.conflicts:
        more = slice(ATTRIBUTES, ATTRIBUTES + CONFLICT_ATTRIBUTES)
        attributes[:near, more] = predicted_conflicts(ego, actors, places, route, rates)
    if spec.motion:
        attributes[:near, -2] = rates.accelerations[places]
        attributes[:near, -1] = rates.turns[places]
    if not spec.speed:
        attributes[:near, 0] = 0.0
    kinds = np.full(count, TokenKind.ROUTE, np.uint8)
    kinds[:near] = TokenKind.VEHICLE
    kinds[rows:] = TokenKind.STOP_LINE
    if spec.vulnerable:
        kinds[:near][_IS_VULNERABLE[actors.kinds[places]]] = TokenKind.VULNERABLE
    all_places = np.full(count, NOWHERE, np.int64)
    all_places[:near] = places
    return Tokens(attributes, kinds, all_places)


def actor_attributes(
    ego: EgoState, actors: Actors, places: Int[np.ndarray, " tokens"]
) -> Float[np.ndarray, "tokens 6"]:
    """Return the six attributes of some actors in the frame of `ego`, in the order of `places`."""
    return _in_frame(np.array(ego.pose), actors.poses, actors.speeds, actors.extents, places)


@compiled(REALS, SINGLES_2D, SINGLES, SINGLES_2D, WHOLES)
def _in_frame(frame, poses, speeds, extents, places):
    cos, sin = math.cos(frame[2]), math.sin(frame[2])
    attributes = np.empty((len(places), ATTRIBUTES))
    for row in range(len(places)):
        actor = places[row]
        dx, dy = poses[actor, 0] - frame[0], poses[actor, 1] - frame[1]
        turn = poses[actor, 2] - frame[2]
        attributes[row, 0] = speeds[actor]
        attributes[row, 1] = cos * dx + sin * dy
        attributes[row, 2] = cos * dy - sin * dx
        attributes[row, 3] = (turn + math.pi) % (2.0 * math.pi) - math.pi
        attributes[row, 4], attributes[row, 5] = extents[actor, 1], extents[actor, 0]
    return attributes


def route_attributes(
    ego: EgoState, route: RouteAhead, spec: TokenSpec
) -> Float[np.ndarray, "segments 6"]:
    """Return the next segments of the route as boxes of the ego's width; fewer near its end."""
    points = route.points[: spec.view + 1]
    if len(points) < 2:
        return np.empty((0, ATTRIBUTES))
    line = shapely.simplify(shapely.linestrings(points), spec.tolerance, preserve_topology=False)
    corners = shapely.get_coordinates(line).tolist()
    rows: list[tuple[float, ...]] = []
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    for (x0, y0), (x1, y1) in _split(corners, spec.longest, spec.segments):
        if rows and math.hypot(x0 - ego.x, y0 - ego.y) > spec.reach:
            break
        dx, dy = 0.5 * (x0 + x1) - ego.x, 0.5 * (y0 + y1) - ego.y
        yaw = wrap_angle(math.atan2(y1 - y0, x1 - x0) - ego.yaw)
        length = math.hypot(x1 - x0, y1 - y0)
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        rows.append((float(len(rows)), x, y, yaw, EGO_WIDTH, length))
    return np.array(rows, dtype=float).reshape(-1, ATTRIBUTES)


def stop_line_attributes(
    ego: EgoState, route: RouteAhead, light: NextLight | None
) -> Float[np.ndarray, "lines 6"]:
    """Return the stop line of a red or yellow light as a box across the route; none otherwise."""
    if light is None or light.state not in STOPS or light.distance < -CROSSED:
        return np.empty((0, ATTRIBUTES))
    along = route.past + 0.5 * EGO_LENGTH + light.distance
    place = min(max(round(along), 0), len(route.points) - 1)
    x, y = route.points[place].tolist()
    cos, sin, dx, dy = math.cos(ego.yaw), math.sin(ego.yaw), x - ego.x, y - ego.y
    yaw = wrap_angle(float(route.headings[place]) - ego.yaw)
    box = (0.0, cos * dx + sin * dy, cos * dy - sin * dx, yaw, EGO_WIDTH, LINE_LENGTH)
    return np.array([box])


def _nearest_first(ego: EgoState, actors: Actors, spec: TokenSpec) -> Int[np.ndarray, " tokens"]:
    """Return the places of the actors that count; equal distances by id, the actors' order."""
    yaws = actors.poses[:, 2]
    counts = actors.kinds != ActorKind.PEDESTRIAN
    return _sorted_near(
        np.array((ego.x, ego.y, ego.yaw, ego.speed, spec.reach, spec.horizon)),
        actors.poses,
        actors.speeds,
        np.cos(yaws),  # of float32: numpy's own, which the C library's do not equal
        np.sin(yaws),
        counts | spec.vulnerable,
        spec.rear,
    )


@compiled(REALS, SINGLES_2D, SINGLES, SINGLES, SINGLES, FLAGS, FLAG)
def _sorted_near(ego, poses, speeds, cos, sin, counts, rear):
    single = np.float32
    x, y, reach, horizon = single(ego[0]), single(ego[1]), ego[4], single(ego[5])
    ego_cos, ego_sin = math.cos(ego[2]), math.sin(ego[2])
    ego_u, ego_v = single(ego[3] * ego_cos), single(ego[3] * ego_sin)
    squares, places, near = np.empty(len(poses), single), np.empty(len(poses), np.int64), 0
    for row in range(len(poses)):
        dx, dy = poses[row, 0] - x, poses[row, 1] - y
        square = dx * dx + dy * dy
        inside = square < single(reach * reach)
        if not inside and horizon > single(0.0):
            u, v = speeds[row] * cos[row] - ego_u, speeds[row] * sin[row] - ego_v
            nearing = max(u * u + v * v, single(LEAST_SQUARE))
            time = min(max(-(dx * u + dy * v) / nearing, single(0.0)), horizon)
            then_x, then_y = dx + u * time, dy + v * time
            inside = then_x * then_x + then_y * then_y < single(reach * reach)
        ahead = single(ego_cos) * dx + single(ego_sin) * dy >= single(0.0)
        if not (inside and counts[row] and (rear or ahead)):
            continue
        place = near  # equal ones stay in their order
        while place and squares[place - 1] > square:
            squares[place], places[place] = squares[place - 1], places[place - 1]
            place -= 1
        squares[place], places[place] = square, row
        near += 1
    return places[:near]


_Point = list[float]


def _split(corners: list[_Point], longest: float, most: int) -> list[tuple[_Point, _Point]]:
    """Return the first pieces of a line, cut at its corners and wherever one gets too long."""
    pieces: list[tuple[_Point, _Point]] = []
    for (x, y), (end_x, end_y) in pairwise(corners):
        left = math.hypot(end_x - x, end_y - y)
        while left > longest + 1e-6 and len(pieces) < most:
            share = longest / left
            cut = [x + share * (end_x - x), y + share * (end_y - y)]
            pieces.append(([x, y], cut))
            (x, y), left = cut, left - longest
        if len(pieces) >= most:
            break
        pieces.append(([x, y], [end_x, end_y]))
    return pieces
