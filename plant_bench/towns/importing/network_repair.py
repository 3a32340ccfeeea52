"""Mending a network: converted again and again until all that is left of it can be driven."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import ParseError

import numpy as np

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
    Way,
    drawn_ways,
    ends_of_edges,
    turnarounds,
    way_of_link,
    with_round_bends,
    without_lines,
    without_ways,
)
from plant_bench.towns.importing.reachable_part import (
    check_what_is_left,
    edges_cut_off,
    findings_of,
    without_narrow_lanes,
)
from plant_bench.world.town import Link, Town

ROUNDS = 12  # conversions until nothing is left to mend
FASTEST = 100.0  # m/s
WIDEST = 50_000.0  # m
MOST_KM = 1000.0  # of lanes
MOST_LANES = 20_000
WORST_GAP = 0.5  # m between the lanes of one way
WORST_ERROR = 0.8  # m that a car following the way leaves it by
TIGHTEST = 2.5  # m of radius: the ego turns in about 4 m, and a lane is wider than the ego

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Mended:
    """A network that can be driven, and what was done to make it so.

    Attributes:
        net: XML text.
        town: What was extracted from it; lanes too narrow to be driven are left out.
        findings: Repairs, and what netconvert said.
    """

    net: str
    town: Town
    findings: list[Finding]


def mend(source: MapSource, name: str, *, guess_signals: bool, say: Progress) -> Mended:
    """Make a network of a map and take from it what cannot be driven.

    Args:
        source: The map.
        name: The town's name.
        guess_signals: Whether netconvert puts signals where traffic seems to need them.
        say: Told what is being done.

    Raises:
        InputError: netconvert cannot use the map, or nothing of it is left that can be driven.
    """
    say(f"Converting {source.file}")
    converted = convert_source(source, guess_signals=guess_signals)
    findings = _of_the_file(source, converted)
    mender = _Mender(source, name, converted.net)
    for number in range(1, ROUNDS + 1):
        say(f"Looking for what cannot be driven, round {number}")
        found = mender.mend_once()
        findings += found
        if not found:
            return Mended(mender.net, mender.town, merged(findings))
    raise InputError(
        f"{source.file}: after {ROUNDS} rounds of repairs there is still something that cannot be "
        f"driven ({findings[-1].what}). Mend the map in netedit, or cut out another part."
    )


def _of_the_file(source: MapSource, converted: Converted) -> list[Finding]:
    findings = reported(
        "netconvert's warnings", "look at these places if a route goes there", converted.warnings
    )
    if not source.internal_lanes:
        done = "netconvert made them from the junctions' shapes"
        findings += repaired("no lanes inside junctions", done, ["the whole map"])
    if source.kind.value == "net" and not source.counts.get("connection"):
        done = "netconvert guessed them"
        findings += repaired("no connections between lanes", done, ["the whole map"])
    return findings


class _Mender:
    """A network on its way to being drivable; mutable."""

    def __init__(self, source: MapSource, name: str, net: str) -> None:
        self.net = net
        self.town = _extract(net, source, name)
        self._source = source
        self._name = name
        self._rounded: set[str] = set()
        self._drives: list[PathDrive] = []

    def mend_once(self) -> list[Finding]:
        """Convert without, or with a better, what is worst; return what that was."""
        for step in (self._turn, self._lift, self._cut, self._redraw, self._round, self._close):
            findings = step()
            if findings:
                return findings
        return []

    def _convert(self, net: str, removed: Sequence[str] = ()) -> None:
        self.net = convert_again(net, removed, self._source.file).net
        self.town = _extract(self.net, self._source, self._name)

    def _turn(self) -> list[Finding]:
        ways = turnarounds(self.net)
        if ways:
            self._convert(without_ways(self.net, ways))
        done = "removed: no car turns on the spot"
        return repaired("turnarounds", done, [f"{before} to {after}" for before, after in ways])

    def _lift(self) -> list[Finding]:
        lifted, findings = lift_crossings(self.net, self.town, ends_of_edges(self.net))
        if findings:
            self._convert(lifted)
        return findings

    def _cut(self) -> list[Finding]:
        """Remove what is cut off from the rest, once the narrow lanes are left out."""
        self.town, narrow = without_narrow_lanes(self.town)
        removed = edges_cut_off(self.town, set(ends_of_edges(self.net)))
        if not removed:
            return []
        check_what_is_left(self.town, removed, self._source.file)
        findings = [*narrow, *findings_of(self.town, removed)]
        self._convert(self.net, removed)
        return findings

    def _redraw(self) -> list[Finding]:
        """Let netconvert draw the ways through junctions that the map draws badly."""
        self._drives = drive_all(self.town)
        links, drawn = _links_by_path(self.town), drawn_ways(self.net)
        paths = [item.path for item in self._drives if is_uneven(item) and item.path in links]
        ways = [way_of_link(links[path]) for path in paths]
        ways = [way for way in ways if way in drawn]
        if ways:
            self._convert(without_lines(self.net, ways))
        done = "drawn anew: the map's own line has gaps or kinks"
        return repaired("uneven ways", done, [f"{before} to {after}" for before, after in ways])

    def _round(self) -> list[Finding]:
        """Round the bends of roads that no car can follow; remove those where that was no help."""
        links = _links_by_path(self.town)
        bent = {
            self.town.lanes[item.path.rsplit("@", 1)[0]].edge
            for item in self._drives
            if item.path not in links and is_undrivable(item)
        }
        ends = ends_of_edges(self.net)
        hopeless = sorted(bent & self._rounded)
        if hopeless:
            self._convert(self.net, hopeless)
            done = "removed: too sharp to be rounded"
            return repaired("roads that bend too sharply", done, hopeless)
        both = [edge for edge in ends if any(set(ends[edge]) == set(ends[one]) for one in bent)]
        if both:
            self._convert(with_round_bends(self.net, both))
            self._rounded.update(both)
        return repaired("roads with sharp bends", "their bends rounded", sorted(bent))

    def _close(self) -> list[Finding]:
        bad, findings = _undrivable(self.town, self._drives)
        if bad:
            self._convert(without_ways(self.net, bad))
        return findings


def _links_by_path(town: Town) -> dict[str, Link]:
    """A town's links by the names that `drive_all` gives to their paths."""
    return {f"{link.source}->{link.target}": link for link in town.links}


def is_uneven(drive: PathDrive) -> bool:
    """Tell whether a path is worse than those of the benchmark's own towns may be."""
    return drive.gap > GAP_MAX_M or drive.radius < RADIUS_MIN_M or drive.error > ERROR_MAX_M


def is_undrivable(drive: PathDrive) -> bool:
    """Tell whether no car can follow a path."""
    return drive.error > WORST_ERROR or drive.radius < TIGHTEST


def _extract(net: str, source: MapSource, name: str) -> Town:
    try:
        town = extract_town(net, name)
    except (LookupError, ValueError, ParseError) as error:
        raise InputError(
            f"netconvert makes a network of {source.file} that cannot be read "
            f"({type(error).__name__}: {in_one_line(error)}): mend the map in netedit."
        ) from error
    if not town.edges:
        raise InputError(f"{source.file} has no road that a car may drive on: take another map.")
    for lane in town.lanes.values():
        if not (np.isfinite(lane.points).all() and 0.0 < lane.speed_limit < FASTEST):
            raise InputError(f"{source.file}: lane {lane.id} has a place or speed that is none.")
    if len(town.lanes) > MOST_LANES:
        raise InputError(
            f"{source.file} has {len(town.lanes)} lanes, {MOST_LANES} at most can be used: cut out "
            "a part of a few kilometres."
        )
    if max(town.extent) > WIDEST or town.lane_km > MOST_KM:
        raise InputError(
            f"{source.file} is {max(town.extent) / 1000:.0f} km wide and has "
            f"{town.lane_km:.0f} km of lanes, {WIDEST / 1000:.0f} km and {MOST_KM:.0f} km at most "
            "can be used: cut out a part."
        )
    return town


def _undrivable(town: Town, drives: Sequence[PathDrive]) -> tuple[list[Way], list[Finding]]:
    """The ways through junctions that no car can follow."""
    links = _links_by_path(town)
    gaps, tight = [], []
    for drive in drives:
        link = links.get(drive.path)
        if link is not None and drive.gap > WORST_GAP:
            gaps.append(link)
        elif link is not None and is_undrivable(drive):
            tight.append(link)
    found = repaired(
        "disconnected lanes",
        f"the way between them removed: a gap of more than {WORST_GAP} m",
        [f"{link.source} to {link.target}" for link in gaps],
    )
    found += repaired(
        "ways too tight to drive",
        f"removed: a car leaves them by more than {WORST_ERROR} m, or they bend within "
        f"{TIGHTEST} m",
        [f"{link.source} to {link.target}" for link in tight],
    )
    return [way_of_link(link) for link in (*gaps, *tight)], found
