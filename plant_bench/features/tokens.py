"""PlanT's object tokens: road users and route segments with six attributes (PlanT, section 3).

A token is (z, x, y, yaw, width, length) in the ego frame: z is an actor's speed, or a route
segment's index. Metres, m/s and radians.
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
from plant_bench.jit import BOOL, BOOL_1D, F32_1D, F32_2D, F64_1D, INT64_1D, compiled
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, ActorKind, Actors, EgoState, Light

ATTRIBUTES = 6
NO_ROW = -1  # instead of an actor's row, for tokens that are no actors
STOPS = (Light.RED, Light.YELLOW)
CROSSED = 1.0  # m past a stop line beyond which it is ignored
LINE_LENGTH = 0.5  # m along the route
MIN_SQUARE = 1e-6  # m2/s2, lower bound of a squared relative speed

_IS_VULNERABLE = np.array([kind in (ActorKind.PEDESTRIAN, ActorKind.BICYCLE) for kind in ActorKind])


class TokenKind(IntEnum):
    """The token types; each has its own embedding."""

    PADDING = 0
    VEHICLE = 1
    ROUTE = 2
    VULNERABLE = 3
    STOP_LINE = 4


@dataclass(frozen=True)
class TokenSpec:
    """Which objects become tokens, and with which attributes.

    Attributes:
        reach: Distance from the ego's centre within which actors become tokens, and within which a
            route segment must start, metres (D_max = 30; PlanT, "Implementation").
        horizon: Also include farther actors that come within `reach` in this time at constant
            velocities, seconds. Not in PlanT; 30 m are two seconds at 50 km/h.
        segments: Number of route segments (N_s = 2; PlanT, "Implementation").
        longest: Maximum length of a segment; longer ones are split; metres (L_max = 10; PlanT,
            "Implementation").
        tolerance: Tolerance of the Ramer-Douglas-Peucker subsampling, metres (0.5; PlanT,
            dataset.py).
        view: Length of route used, metres (50; PlanT, dataset.py).
        speed: Whether tokens include actors' speeds (PlanT, table 2).
        rear: Whether actors behind the ego become tokens (PlanT, table 2).
        vulnerable: Whether pedestrians and cyclists become tokens of their own type. PlanT leaves
            out pedestrians and treats cyclists as vehicles.
        stop_line: Whether the stop line of a red or yellow light becomes a token: a box across the
            route. PlanT has only a flag for such a light, without its position.
        conflicts: Whether actors have four more attributes: where and when they conflict with the
            ego's route under constant motion (`features.predicted_conflicts`). Not in PlanT.
        motion: Whether actors have two more attributes, acceleration and turn rate
            (`features.motion`), which predicted conflicts then assume constant. Not in PlanT.
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
        """Number of attributes per token."""
        return ATTRIBUTES + CONFLICT_ATTRIBUTES * self.conflicts + MOTION_ATTRIBUTES * self.motion


@dataclass(frozen=True, eq=False, slots=True)
class Tokens:
    """The tokens of one scene: actors, nearest first; then route segments; then the stop line.

    Attributes:
        attributes: z, x, y, yaw, width, length; then those of `conflicts` and `motion`, 0 for
            tokens that are no actors.
        kinds: `TokenKind` values.
        places: Row in the observation's actors; `NO_ROW` for tokens that are no actors.
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
    """Return the tokens of a scene."""
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
    all_places = np.full(count, NO_ROW, np.int64)
    all_places[:near] = places
    return Tokens(attributes, kinds, all_places)


def actor_attributes(
    ego: EgoState, actors: Actors, places: Int[np.ndarray, " tokens"]
) -> Float[np.ndarray, "tokens 6"]:
    """Return six attributes per actor in the frame of `ego`, in the order of the rows `places`."""
    return _in_frame(np.array(ego.pose), actors.poses, actors.speeds, actors.extents, places)


@compiled(F64_1D, F32_2D, F32_1D, F32_2D, INT64_1D)
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
    """Return the rows of the actors that become tokens, nearest first; ties in their order."""
    yaws = actors.poses[:, 2]
    counts = actors.kinds != ActorKind.PEDESTRIAN
    return _sorted_near(
        np.array((ego.x, ego.y, ego.yaw, ego.speed, spec.reach, spec.horizon)),
        actors.poses,
        actors.speeds,
        np.cos(yaws),  # numpy's float32 cosine, which differs from the C library's
        np.sin(yaws),
        counts | spec.vulnerable,
        spec.rear,
    )


@compiled(F64_1D, F32_2D, F32_1D, F32_1D, F32_1D, BOOL_1D, BOOL)
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
            square_speed = max(u * u + v * v, single(MIN_SQUARE))
            time = min(max(-(dx * u + dy * v) / square_speed, single(0.0)), horizon)
            then_x, then_y = dx + u * time, dy + v * time
            inside = then_x * then_x + then_y * then_y < single(reach * reach)
        ahead = single(ego_cos) * dx + single(ego_sin) * dy >= single(0.0)
        if not (inside and counts[row] and (rear or ahead)):
            continue
        place = near  # stable insertion sort
        while place and squares[place - 1] > square:
            squares[place], places[place] = squares[place - 1], places[place - 1]
            place -= 1
        squares[place], places[place] = square, row
        near += 1
    return places[:near]


_Point = list[float]


def _split(corners: list[_Point], longest: float, most: int) -> list[tuple[_Point, _Point]]:
    """Return the first `most` pieces of a polyline, cut at its corners and at `longest` metres."""
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
