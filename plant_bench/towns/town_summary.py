"""Counts the contents of a town's network: lanes, junctions, signals, ramps and so on."""

from dataclasses import dataclass

import numpy as np

from plant_bench.geometry.pose import wrap_angle
from plant_bench.towns.street_shapes import end_pose, start_pose
from plant_bench.world.town import Lane, Town

BEND = float(np.radians(45))
TIGHT_TURN = float(np.radians(150))
LEVELS_APART_M = 4.5


@dataclass(frozen=True)
class TownSummary:
    """Contents of a town's network.

    Attributes:
        name: The town.
        extent: Width and height, metres.
        lane_km: Total length of lanes outside junctions, kilometres.
        multi_lane_km: The part of `lane_km` on edges of two or more lanes, kilometres.
        edges: Number of one-way edges outside junctions.
        junctions: Number of junctions by kind ("joint": edges just join).
        signals: Number of signalled junctions.
        signalled_t_junctions: Number of signalled junctions with three arms.
        signalled_crossroads: Number of signalled junctions with four arms.
        large_junctions: Number of junctions with five or more arms.
        roundabouts: Number of roundabouts.
        on_ramps: Number of acceleration lanes.
        off_ramps: Number of exits from a highway that keep its number of lanes.
        u_turns: Number of one-way edges that turn back over a median.
        curves: Number of edges that turn by 45 degrees or more.
        bridges: Number of pairs of edges that cross at two levels.
    """

    name: str
    extent: tuple[float, float]
    lane_km: float
    multi_lane_km: float
    edges: int
    junctions: dict[str, int]
    signals: int
    signalled_t_junctions: int
    signalled_crossroads: int
    large_junctions: int
    roundabouts: int
    on_ramps: int
    off_ramps: int
    u_turns: int
    curves: int
    bridges: int


def summarise(town: Town) -> TownSummary:
    """Count what a town contains."""
    kinds = [junction.kind for junction in town.junctions.values()]
    arms = [j.arms for j in town.junctions.values() if j.kind == "signal"]
    turns = [_turned(lanes[0]) for lanes in town.edges.values()]
    multi = [lane for lanes in town.edges.values() if len(lanes) > 1 for lane in lanes]
    return TownSummary(
        name=town.name,
        extent=town.extent,
        lane_km=town.lane_km,
        multi_lane_km=sum(lane.length for lane in multi) / 1000,
        edges=len(town.edges),
        junctions={kind: kinds.count(kind) for kind in sorted(set(kinds))},
        signals=len(town.signals),
        signalled_t_junctions=arms.count(3),
        signalled_crossroads=arms.count(4),
        large_junctions=sum(j.arms >= 5 for j in town.junctions.values() if j.kind != "joint"),
        roundabouts=len(town.roundabouts),
        on_ramps=_on_ramps(town),
        off_ramps=_off_ramps(town),
        u_turns=sum(_is_u_turn(lanes) for lanes in town.edges.values()),
        curves=sum(abs(turn) >= BEND for turn in turns),
        bridges=_bridges(town),
    )


def _turned(lane: Lane) -> float:
    return wrap_angle(end_pose(lane.points).heading - start_pose(lane.points).heading)


def _is_u_turn(lanes: tuple[Lane, ...]) -> bool:
    turned_back = abs(_turned(lanes[0])) > TIGHT_TURN
    return len(lanes) == 1 and turned_back and lanes[0].length < 60


def _on_ramps(town: Town) -> int:
    return sum(lane.acceleration and lane.right is None for lane in town.lanes.values())


def _off_ramps(town: Town) -> int:
    """Count edges whose rightmost lane alone leads to an exit, without any yielding."""
    found = 0
    for lanes in town.edges.values():
        onward = [town.links_from.get(lane.id, ()) for lane in lanes]
        targets = [{town.lanes[link.target].edge for link in links} for links in onward]
        joint = all(link.control == "major" for links in onward for link in links)
        leads_away = targets[0] and not targets[0] & set().union(*targets[1:])
        found += bool(len(lanes) > 2 and joint and leads_away)
    return found


def _bridges(town: Town) -> int:
    """Count pairs of edges that cross in the plane at different heights."""
    lines = [(edge, lanes[0].points) for edge, lanes in town.edges.items()]
    high = [(edge, points) for edge, points in lines if points[:, 2].max() > 1]
    return sum(
        _cross_apart(points, other)
        for edge, points in high
        for name, other in lines
        if name != edge
    )


def _cross_apart(upper: np.ndarray, lower: np.ndarray) -> bool:
    """Return whether the first line passes over the second."""
    starts, ends = upper[:-1, None], upper[1:, None]
    begins, stops = lower[None, :-1], lower[None, 1:]
    a, b, c = ends - starts, stops - begins, begins - starts
    area = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    safe = np.where(np.abs(area) < 1e-9, np.inf, area)
    t = (c[..., 0] * b[..., 1] - c[..., 1] * b[..., 0]) / safe
    u = (c[..., 0] * a[..., 1] - c[..., 1] * a[..., 0]) / safe
    over = starts[..., 2] + t * a[..., 2] - begins[..., 2] - u * b[..., 2]
    hit = (np.abs(area) > 1e-9) & (t >= 0) & (t <= 1) & (u >= 0) & (u <= 1)
    return bool((hit & (over > LEVELS_APART_M)).any())
