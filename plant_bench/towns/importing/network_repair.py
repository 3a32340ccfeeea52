"""Repairs an imported network: converts it repeatedly until every remaining path can be driven.

A path that no car can follow is drawn again, widened or rounded before it is removed.
Each step either enlarges a bounded quantity or removes something, so that the repairs end.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import ParseError

import numpy as np
import shapely
from shapely.geometry import Point, Polygon

from plant_bench.errors import InputError, in_one_line
from plant_bench.towns.drivable import (
    ERROR_MAX_M,
    GAP_MAX_M,
    RADIUS_MIN_M,
    PathDrive,
    drive_all,
)
from plant_bench.towns.extract import extract_town
from plant_bench.towns.importing.levels import lift_crossings
from plant_bench.towns.importing.map_conversion import Converted, convert_again, convert_source
from plant_bench.towns.importing.map_findings import Finding, merged, repaired, reported
from plant_bench.towns.importing.map_source import MapSource
from plant_bench.towns.importing.net_edits import (
    LanePair,
    connections_with_shape,
    ends_of_edges,
    lane_pair_of_link,
    turnarounds,
    with_fixed_junctions,
    with_junction_shapes,
    with_round_bends,
    without_connections,
    without_shapes,
)
from plant_bench.towns.importing.reachable_part import (
    check_remaining,
    lane_metres,
    removal_findings,
    unreachable_edges,
    without_narrow_lanes,
)
from plant_bench.towns.importing.short_lanes import straighten_short_lanes
from plant_bench.towns.importing.signal_cycles import bound_cycles
from plant_bench.world.town import Link, Town

MAX_SPEED = 100.0  # m/s
MAX_EXTENT = 50_000.0  # m
MAX_LANE_KM = 1000.0
MAX_LANES = 20_000
TOLERATED_GAP = 0.5  # m between consecutive lanes of a path
TOLERATED_ERROR = 0.8  # m of tracking error of a car that follows the path
TOLERATED_RADIUS = 2.5  # m: tighter connections are widened
JUNCTION_RADII = (8.0, 12.0, 16.0)  # m around a junction's centre that its outline is widened to
ROAD_SHARE = 0.4  # of the shortest road at a junction that may be given to it
BEND_SPREADS = (6.0, 12.0, 20.0)  # m: standard deviations of the blur that rounds bends

Progress = Callable[[str], None]


@dataclass(frozen=True)
class RepairedNetwork:
    """A network that can be driven, and the repairs that it needed.

    Attributes:
        net: XML text.
        town: The town extracted from it, without lanes too narrow to drive on.
        findings: Repairs and netconvert's warnings.
    """

    net: str
    town: Town
    findings: list[Finding]


def repair_network(
    source: MapSource, name: str, *, guess_signals: bool, say: Progress
) -> RepairedNetwork:
    """Convert a map to a network, and repair or remove what cannot be driven.

    Args:
        source: The map.
        name: The town's name.
        guess_signals: Whether netconvert guesses which junctions have signals.
        say: Called with a progress message before each step.

    Raises:
        InputError: netconvert fails, or too little of the map can be driven.
    """
    say(f"Converting {source.file}")
    converted = convert_source(source, guess_signals=guess_signals)
    findings = _conversion_findings(source, converted)
    repairer = _Repairer(source, name, converted.net)
    for number in itertools.count(1):
        say(f"Repairing the network, round {number}")
        found = repairer.repair_once()
        findings += found
        if not found:
            break
    net, long_cycles = bound_cycles(repairer.net)
    return RepairedNetwork(net, repairer.town, merged([*findings, *repairer.narrow, *long_cycles]))


def _conversion_findings(source: MapSource, converted: Converted) -> list[Finding]:
    findings = reported(
        "netconvert's warnings", "check these places if a route passes them", converted.warnings
    )
    for problem, done in converted.workarounds:
        findings += repaired(problem, done, ["the whole map"])
    if not source.internal_lanes:
        done = "created by netconvert from the junctions' shapes"
        findings += repaired("no lanes inside junctions", done, ["the whole map"])
    if source.kind.value == "net" and not source.counts.get("connection"):
        done = "guessed by netconvert"
        findings += repaired("no connections between lanes", done, ["the whole map"])
    return findings


class _Repairer:
    """A network under repair; mutable."""

    def __init__(self, source: MapSource, name: str, net: str) -> None:
        self.net = net
        self.town = _extract(net, source, name)
        self.narrow: list[Finding] = []  # lanes left out since the first round
        self._source = source
        self._name = name
        self._smoothed: dict[frozenset[str], int] = {}  # ends of a road: how often it was smoothed
        self._widened: dict[str, int] = {}  # junction: how often it was widened
        self._drives: list[PathDrive] = []
        self._cut_off = False  # whether something that cannot be driven was just removed

    def repair_once(self) -> list[Finding]:
        """Apply the first repair that finds a problem; return its findings."""
        for step in (
            self._remove_turnarounds,
            self._raise_crossings,
            self._remove_unreachable,
            self._replace_shapes,
            self._widen_junctions,
            self._smooth_bends,
            self._remove_undrivable,
        ):
            findings = step()
            if findings:
                return findings
        return []

    def _convert(self, net: str, removed: Sequence[str] = ()) -> None:
        self.net = convert_again(net, removed, self._source.file).net
        self.town = _extract(self.net, self._source, self._name)

    def _remove_turnarounds(self) -> list[Finding]:
        pairs = turnarounds(self.net)
        if pairs:
            self._convert(without_connections(self.net, pairs))
        done = "removed: cars cannot turn on the spot"
        return repaired("turnarounds", done, [f"{before} to {after}" for before, after in pairs])

    def _raise_crossings(self) -> list[Finding]:
        lifted, findings = lift_crossings(self.net, self.town, ends_of_edges(self.net))
        if findings:
            self._convert(lifted)
        return findings

    def _remove_unreachable(self) -> list[Finding]:
        """Leave out narrow lanes, and remove edges that are unreachable or have no way out."""
        cut_off, self._cut_off = self._cut_off, False
        self.town, narrow = without_narrow_lanes(self.town)
        self.narrow = self.narrow or narrow
        ends = ends_of_edges(self.net)
        removed = unreachable_edges(self.town, ends)
        if not removed:
            return []
        check_remaining(self.town, removed, self._source.file)
        findings = removal_findings(self.town, removed, cut_off=cut_off)
        touched = {junction for edge in removed for junction in ends[edge]}
        self._convert(with_fixed_junctions(self.net, touched), removed)
        return findings

    def _replace_shapes(self) -> list[Finding]:
        """Let netconvert compute the connections whose shapes in the map are uneven."""
        self._drives = drive_all(self.town)
        links, drawn = _links_by_path(self.town), connections_with_shape(self.net)
        paths = [item.path for item in self._drives if is_uneven(item) and item.path in links]
        pairs = [lane_pair_of_link(links[path]) for path in paths]
        pairs = [pair for pair in pairs if pair in drawn]
        if pairs:
            self._convert(without_shapes(self.net, pairs))
        done = "drawn again: their shapes in the map had gaps or kinks"
        return repaired(
            "uneven connections", done, [f"{before} to {after}" for before, after in pairs]
        )

    def _widen_junctions(self) -> list[Finding]:
        """Widen junctions with connections that are too tight, as far as their roads allow."""
        links = _links_by_path(self.town)
        tight = sorted(
            {
                links[item.path].junction
                for item in self._drives
                if item.path in links and is_tight(item)
            }
        )
        outlines = {}
        for junction in tight:
            level = self._widened.get(junction, 0)
            if level < len(JUNCTION_RADII):
                self._widened[junction] = level + 1
                outline = self._widened_outline(junction, JUNCTION_RADII[level])
                if outline is not None:
                    outlines[junction] = outline
        if outlines:
            self._convert(with_junction_shapes(self.net, outlines))
        return repaired("junctions too tight to turn", "widened", sorted(outlines))

    def _widened_outline(self, junction: str, radius: float) -> np.ndarray | None:
        """Return a junction's outline joined with a circle; None if its roads are too short."""
        roads = [
            self.town.edges[edge][0].length
            for edge, ends in ends_of_edges(self.net).items()
            if junction in ends and edge in self.town.edges
        ]
        node = self.town.junctions[junction]
        if radius > ROAD_SHARE * min(roads, default=0.0) or len(node.outline) < 3:
            return None
        shape = Polygon(node.outline).buffer(0.0).union(Point(node.x, node.y).buffer(radius))
        return shapely.get_coordinates(shape.convex_hull)[:-1]

    def _smooth_bends(self) -> list[Finding]:
        """Smooth the bends of roads that no car can follow; remove those still too sharp."""
        links = _links_by_path(self.town)
        bent = {
            self.town.lanes[item.path.rsplit("@", 1)[0]].edge
            for item in self._drives
            if item.path not in links and is_undrivable(item)
        }
        roads = {edge: frozenset(ends) for edge, ends in ends_of_edges(self.net).items()}
        spent = sorted(
            edge for edge in bent if self._smoothed.get(roads[edge], 0) == len(BEND_SPREADS)
        )
        if spent:
            metres = lane_metres(self.town, spent)
            self._convert(self.net, spent)
            self._cut_off = True
            done = "removed: too sharp to smooth"
            return repaired("roads that bend too sharply", done, spent, metres)
        levels = {road: self._smoothed.get(road, 0) for road in {roads[edge] for edge in bent}}
        spreads = {  # both directions of a road together
            edge: BEND_SPREADS[levels[road]] for edge, road in roads.items() if road in levels
        }
        if spreads:
            self._convert(with_round_bends(self.net, spreads))
            self._smoothed.update({road: level + 1 for road, level in levels.items()})
        return repaired("roads with sharp bends", "bends smoothed", sorted(bent))

    def _remove_undrivable(self) -> list[Finding]:
        bad, findings = _undrivable(self.town, self._drives)
        if bad:
            self._convert(without_connections(self.net, bad))
            self._cut_off = True
        return findings


def _links_by_path(town: Town) -> dict[str, Link]:
    """Return a town's links by the path names of `drive_all`."""
    return {f"{link.source}->{link.target}": link for link in town.links}


def is_uneven(drive: PathDrive) -> bool:
    """Return whether a path exceeds the limits of the benchmark's own towns."""
    return drive.gap > GAP_MAX_M or drive.radius < RADIUS_MIN_M or drive.error > ERROR_MAX_M


def is_tight(drive: PathDrive) -> bool:
    """Tell whether a car can follow a path only roughly."""
    return drive.error > TOLERATED_ERROR or (
        drive.radius < TOLERATED_RADIUS and drive.error > ERROR_MAX_M
    )


def is_undrivable(drive: PathDrive) -> bool:
    """Tell whether no car can follow a path."""
    return drive.error > TOLERATED_ERROR


def _extract(net: str, source: MapSource, name: str) -> Town:
    try:
        town = straighten_short_lanes(extract_town(net, name))
    except (LookupError, ValueError, ParseError) as error:
        raise InputError(
            f"netconvert makes a network of {source.file} that cannot be read "
            f"({type(error).__name__}: {in_one_line(error)}): repair the map in netedit."
        ) from error
    if not town.edges:
        raise InputError(f"{source.file} has no road that cars may drive on: use another map.")
    for lane in town.lanes.values():
        if not (np.isfinite(lane.points).all() and 0.0 < lane.speed_limit < MAX_SPEED):
            raise InputError(
                f"{source.file}: lane {lane.id} has an invalid position or speed limit."
            )
    if len(town.lanes) > MAX_LANES:
        raise InputError(
            f"{source.file} has {len(town.lanes)} lanes, more than the limit of {MAX_LANES}: cut "
            "out a part of a few kilometres."
        )
    if max(town.extent) > MAX_EXTENT or town.lane_km > MAX_LANE_KM:
        raise InputError(
            f"{source.file} is {max(town.extent) / 1000:.0f} km wide and has "
            f"{town.lane_km:.0f} km of lanes; the limits are {MAX_EXTENT / 1000:.0f} km and "
            f"{MAX_LANE_KM:.0f} km: cut out a part."
        )
    return town


def _undrivable(town: Town, drives: Sequence[PathDrive]) -> tuple[list[LanePair], list[Finding]]:
    """Return the connections that no car can follow, and the findings of removing them."""
    links = _links_by_path(town)
    gaps, tight = [], []
    for drive in drives:
        link = links.get(drive.path)
        if link is not None and drive.gap > TOLERATED_GAP:
            gaps.append(link)
        elif link is not None and is_undrivable(drive):
            tight.append(link)
    found = repaired(
        "disconnected lanes",
        f"connection removed: a gap of more than {TOLERATED_GAP} m",
        [f"{link.source} to {link.target}" for link in gaps],
    )
    found += repaired(
        "connections too tight to drive",
        f"removed: a car leaves them by more than {TOLERATED_ERROR} m",
        [f"{link.source} to {link.target}" for link in tight],
    )
    return [lane_pair_of_link(link) for link in (*gaps, *tight)], found
