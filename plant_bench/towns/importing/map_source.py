"""The door for map files: what they are, and that they are harmless, before anything uses them.

A file is refused for a document type (entity bombs, external entities), for includes, for its size
or depth, and for left-hand traffic. What passes is handed on as bytes, never by the file's name.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from plant_bench.errors import InputError
from plant_bench.towns.extract import carries_cars
from plant_bench.towns.importing.safe_xml import read_limited, scan_xml

MOST_BYTES = 200 * 2**20
WANTED = "a SUMO network (.net.xml), an OpenDRIVE (.xodr) or an OpenStreetMap (.osm) file is wanted"
_LEFT = (
    "has left-hand traffic, and the benchmark drives on the right: mirror the map, or take another"
)
MOST_ABREAST = 50  # lanes of a road; netconvert works for minutes on thousands
_NO_CARS = (
    "footway", "cycleway", "pedestrian", "steps", "path", "bridleway",
    "sidewalk", "biking", "tram", "rail",
)  # fmt: skip


class MapKind(StrEnum):
    """What a map file is, told by its first element."""

    SUMO = "net"
    OPENDRIVE = "OpenDRIVE"
    OSM = "osm"


@dataclass(frozen=True)
class MapSource:
    """A map file that has passed all checks.

    Attributes:
        file: Its name, without folders.
        kind: What it is.
        content: Its bytes, unpacked.
        counts: How many elements there are of each name.
        no_cars: How many ways there are for feet, bicycles or trains only.
        internal_lanes: False for a SUMO network without lanes inside its junctions.
    """

    file: str
    kind: MapKind
    content: bytes = field(repr=False)
    counts: Mapping[str, int]
    no_cars: int = 0
    internal_lanes: bool = True


def read_source(path: Path) -> MapSource:
    """Read a map file and check it.

    Raises:
        InputError: It is missing, no map, damaged, too large, hostile or of left-hand traffic.
    """
    if not path.is_file():
        raise InputError(f"There is no map file {path}: {WANTED}.")
    content = read_limited(path, MOST_BYTES)
    checker = _Checker(path)
    scan_xml(content, path, checker)
    return MapSource(
        path.name,
        MapKind(checker.root),
        content,
        dict(checker.counts),
        checker.others + len(checker.edges - checker.car_edges),
        checker.internal,
    )


class _Checker:
    """Looks at each element of a map; mutable."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.root = ""
        self.counts = Counter[str]()
        self.internal = False
        self.others = 0
        self.edges: set[str] = set()
        self.car_edges: set[str] = set()
        self._edge = ""

    def __call__(self, name: str, attributes: Mapping[str, str]) -> None:
        """Look at an element.

        Raises:
            InputError: It is none that a map may have.
        """
        if not self.root:
            self._begin(name, attributes)
        self.counts[name] += 1
        if name == "include":
            self._refuse("refers to another file by <include>: put its content in its place")
        if name == "road" and attributes.get("rule") == "LHT":
            self._refuse(_LEFT)
        if name == "tag" and (attributes.get("k"), attributes.get("v")) == ("driving_side", "left"):
            self._refuse(_LEFT)
        if name == "tag" and attributes.get("k", "").startswith("lanes"):
            self._check_lanes(attributes.get("v", ""))
        self._count_ways(name, attributes)

    def _check_lanes(self, count: str) -> None:
        if count.strip().isdecimal() and int(count[:9]) > MOST_ABREAST:
            self._refuse(f"has a road of {count[:9]} lanes, {MOST_ABREAST} at most can be used")

    def _count_ways(self, name: str, attributes: Mapping[str, str]) -> None:
        if attributes.get("function") == "internal":
            self.internal = True
        if self.root == MapKind.OSM and name == "tag":
            highway = attributes.get("k") == "highway" and attributes.get("v") in _NO_CARS
            self.others += highway or attributes.get("k") == "railway"
        elif self.root == MapKind.OPENDRIVE and name == "lane":
            self.others += attributes.get("type") in _NO_CARS
        elif self.root == MapKind.SUMO and name == "edge":
            self._edge = attributes.get("id", "")
            if "function" not in attributes:
                self.edges.add(self._edge)
        elif self.root == MapKind.SUMO and name == "lane" and carries_cars(attributes):
            self.car_edges.add(self._edge)

    def _begin(self, name: str, attributes: Mapping[str, str]) -> None:
        self.root = name
        if name not in list(MapKind):
            self._refuse(f"begins with <{name[:40]}>: {WANTED}")
        self.internal = name != MapKind.SUMO
        if name == MapKind.SUMO and attributes.get("lefthand", "false") not in ("false", "0"):
            self._refuse(_LEFT)

    def _refuse(self, what: str) -> None:
        raise InputError(f"{self._path} {what}.")
