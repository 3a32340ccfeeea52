"""Reads an untrusted map file: detects its format and checks that it is safe to convert.

A file is refused for a document type (entity bombs, external entities), for includes, for its size
or depth, and for left-hand traffic. Accepted content is passed on as bytes, never as a file name.
"""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.towns.extract import carries_cars
from plant_bench.towns.importing.safe_xml import read_limited, scan_xml

MAX_BYTES = 200 * 2**20
PBF_HEADER = b"OSMHeader"
EXPECTED = "expected a SUMO network (.net.xml), OpenDRIVE (.xodr) or OpenStreetMap (.osm) file"
_LEFT_HAND = (
    "has left-hand traffic, but the benchmark drives on the right: mirror the map, or use another"
)
MAX_ROAD_LANES = 50  # lanes of a road; netconvert takes minutes for thousands
_NON_CAR_TYPES = (
    "footway", "cycleway", "pedestrian", "steps", "path", "bridleway",
    "sidewalk", "biking", "tram", "rail",
)  # fmt: skip


class MapKind(StrEnum):
    """Format of a map file; the value is the name of its root element."""

    SUMO = "net"
    OPENDRIVE = "OpenDRIVE"
    OSM = "osm"


@dataclass(frozen=True)
class MapSource:
    """A map file that has passed all checks.

    Attributes:
        file: File name without folders.
        kind: Format.
        content: Decompressed bytes.
        counts: Number of elements by name.
        non_car_ways: Number of ways for pedestrians, bicycles or trains only.
        internal_lanes: False for a SUMO network without lanes inside its junctions.
        header_offset: x and y of the header's <offset> in an OpenDRIVE map, metres: where the map
            lies on Earth; no coordinate of the map changes with it.
    """

    file: str
    kind: MapKind
    content: bytes = field(repr=False)
    counts: Mapping[str, int]
    non_car_ways: int = 0
    internal_lanes: bool = True
    header_offset: tuple[float, float] = (0.0, 0.0)


def read_source(path: Path) -> MapSource:
    """Read a map file and check it.

    Raises:
        InputError: The file is missing, no map, damaged, too large or unsafe, or has left-hand
            traffic.
    """
    if not path.is_file():
        raise InputError(f"There is no map file {path}: {EXPECTED}.")
    content = read_limited(path, MAX_BYTES)
    if PBF_HEADER in content[:64]:
        raise InputError(
            f"{path} is an OpenStreetMap file in PBF format: convert it to XML with "
            f"`osmium cat {path.name} -o map.osm`, and cut out the part that you need."
        )
    checker = _Checker(path)
    scan_xml(content, path, checker)
    return MapSource(
        path.name,
        MapKind(checker.root),
        content,
        dict(checker.counts),
        checker.others + len(checker.edges - checker.car_edges),
        checker.internal,
        checker.header_offset,
    )


class _Checker:
    """Checks and counts the elements of a map; mutable."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.root = ""
        self.counts = Counter[str]()
        self.internal = False
        self.others = 0
        self.edges: set[str] = set()
        self.car_edges: set[str] = set()
        self._edge = ""
        self._name = ""
        self.header_offset = (0.0, 0.0)

    def __call__(self, name: str, attributes: Mapping[str, str]) -> None:
        """Check and count an element.

        Raises:
            InputError: The element is not allowed.
        """
        if not self.root:
            self._check_root(name, attributes)
        self.counts[name] += 1
        if name == "include":
            self._refuse("refers to another file by <include>: insert that file's content instead")
        if name == "road" and attributes.get("rule") == "LHT":
            self._refuse(_LEFT_HAND)
        if name == "tag" and (attributes.get("k"), attributes.get("v")) == ("driving_side", "left"):
            self._refuse(_LEFT_HAND)
        if name == "tag" and attributes.get("k", "").startswith("lanes"):
            self._check_lanes(attributes.get("v", ""))
        if self.root == MapKind.OPENDRIVE and name == "offset":
            self._read_offset(attributes)
        if name == "tag" and attributes == {"k": "type", "v": "lanelet"}:
            self._refuse(
                "is a Lanelet2 map, which cannot be imported: convert it to OpenDRIVE, for "
                "instance with CommonRoad's scenario designer"
            )
        self._count_ways(name, attributes)

    def _read_offset(self, attributes: Mapping[str, str]) -> None:
        try:
            x, y = (float(attributes.get(axis, "0")) for axis in "xy")
        except ValueError:
            self._refuse(f"has a header offset that is no number: {dict(attributes)}")
        else:
            self.header_offset = (x, y) if math.isfinite(x) and math.isfinite(y) else (0.0, 0.0)

    def _check_lanes(self, count: str) -> None:
        if count.strip().isdecimal() and int(count[:9]) > MAX_ROAD_LANES:
            self._refuse(
                f"has a road of {count[:9]} lanes, more than the limit of {MAX_ROAD_LANES}"
            )

    def _count_ways(self, name: str, attributes: Mapping[str, str]) -> None:
        if attributes.get("function") == "internal":
            self.internal = True
        if self.root == MapKind.OSM and name == "tag":
            highway = attributes.get("k") == "highway" and attributes.get("v") in _NON_CAR_TYPES
            self.others += highway or attributes.get("k") == "railway"
        elif self.root == MapKind.OPENDRIVE and name == "lane":
            self.others += attributes.get("type") in _NON_CAR_TYPES
        elif self.root == MapKind.SUMO and name == "edge":
            self._edge = attributes.get("id", "")
            if "function" not in attributes:
                self.edges.add(self._edge)
        elif self.root == MapKind.SUMO and name == "lane" and carries_cars(attributes):
            self.car_edges.add(self._edge)

    def _check_root(self, name: str, attributes: Mapping[str, str]) -> None:
        self.root = name
        if name not in list(MapKind):
            self._refuse(f"begins with <{name[:40]}>: {EXPECTED}")
        self.internal = name != MapKind.SUMO
        if name == MapKind.SUMO and attributes.get("lefthand", "false") not in ("false", "0"):
            self._refuse(_LEFT_HAND)

    def _refuse(self, what: str) -> None:
        raise InputError(f"{self._path} {what}.")
