"""Reports problems of an imported town that are not repaired."""

from collections.abc import Mapping

import numpy as np

from plant_bench.towns.drivable import drive_all
from plant_bench.towns.importing.levels import report_flat_crossings
from plant_bench.towns.importing.map_findings import REPAIRED, Finding, reported
from plant_bench.towns.importing.map_source import MapSource
from plant_bench.towns.importing.network_repair import is_uneven
from plant_bench.towns.town_checks import find_dead_lanes
from plant_bench.world.town import Lane, Town

BIG_ARMS = 4  # roads that meet at a big junction
BIG_LANES = 6  # incoming lanes of a big junction
FAST = 11.0  # m/s: slower junctions do without signals
TINY = 1.0  # m
OVERLAP = 0.5  # share of a lane's width


def check(town: Town, source: MapSource, ends: Mapping[str, tuple[str, str]]) -> list[Finding]:
    """Return the problems of a town that were not repaired."""
    return [
        *_missing_signals(town),
        *_shapes(town),
        *reported(
            "lanes without a predecessor or successor", "no route uses them", find_dead_lanes(town)
        ),
        *report_flat_crossings(town, ends),
        *_tiny(town),
        *_wrong_way(town, ends),
        *_left_out(source),
    ]


def _missing_signals(town: Town) -> list[Finding]:
    arriving: dict[str, set[str]] = {}
    for link in town.links:
        arriving.setdefault(link.junction, set()).add(link.source)
    names = []
    for junction in town.junctions.values():
        lanes = [town.lanes[name] for name in arriving.get(junction.id, ())]
        big = junction.arms >= BIG_ARMS and len(lanes) >= BIG_LANES
        fast = max((lane.speed_limit for lane in lanes), default=0.0) > FAST
        if big and fast and junction.kind not in ("signal", "roundabout", "joint"):
            names.append(f"{junction.id} at {junction.x:.0f}, {junction.y:.0f}")
    return reported("big junctions without signals", "--guess-signals adds some", names)


def _shapes(town: Town) -> list[Finding]:
    names = [drive.path for drive in drive_all(town) if is_uneven(drive)]
    return reported("tight or uneven paths", "drivable, but planners may cut corners", names)


def _tiny(town: Town) -> list[Finding]:
    names = [edge for edge, lanes in town.edges.items() if lanes[0].length < TINY]
    return reported("edges shorter than a metre", "no route starts or ends there", names)


def _wrong_way(town: Town, ends: Mapping[str, tuple[str, str]]) -> list[Finding]:
    """Report lanes of opposite directions that overlap."""
    by_ends = {ends[edge]: lanes for edge, lanes in town.edges.items()}
    names = []
    for edge, lanes in town.edges.items():
        begin, end = ends[edge]
        opposite = by_ends.get((end, begin))
        if opposite is not None and edge < opposite[0].edge and _overlap(lanes[-1], opposite[-1]):
            names.append(f"{edge} and {opposite[0].edge}")
    return reported("lanes of opposite directions that overlap", "head-on collisions", names)


def _overlap(one: Lane, other: Lane) -> bool:
    middle = np.array([np.interp(one.length / 2, one.along, c) for c in one.points[:, :2].T])
    nearest = np.hypot(*(_dense(other) - middle).T).min()
    return bool(nearest < OVERLAP * (one.width + other.width) / 2)


def _dense(lane: Lane) -> np.ndarray:
    at = np.arange(0.0, lane.length, 0.5)
    return np.stack([np.interp(at, lane.along, column) for column in lane.points[:, :2].T], axis=1)


def _left_out(source: MapSource) -> list[Finding]:
    if not source.non_car_ways:
        return []
    done = "left out, except sidewalks beside a road"
    return [
        Finding(
            "ways for pedestrians, bicycles or trains only", REPAIRED, source.non_car_ways, done
        )
    ]
