"""The road network of a town: lanes, links between them, junctions and signals.

It is stored in `networks/<town>/town.json`, so that only `towns` and `sim` need SUMO.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from jaxtyping import Float

from plant_bench.data_files import town_dir
from plant_bench.errors import InputError, in_one_line
from plant_bench.geometry.polyline import arc_lengths
from plant_bench.untrusted_files import parse_json, read_text
from plant_bench.world.town_schema import TownPayload

TOWN_FORMAT = 2


@dataclass(frozen=True, eq=False)
class Lane:
    """One lane that vehicles may drive on; ids are SUMO's.

    Attributes:
        id: Lane id.
        edge: Edge id; internal edges (inside a junction) start with a colon.
        index: SUMO's index on the edge, counted from the right, sidewalks included.
        points: Centre line in the direction of travel, x, y, z.
        width: Metres.
        speed_limit: m/s.
        junction: The junction the lane crosses, None outside junctions.
        successors: Lanes that continue this one without a lane change (internal lanes included).
        left: The adjacent lane to the left in the same direction, or None.
        right: The adjacent lane to the right in the same direction, or None.
        acceleration: True for an acceleration lane, which ends without a successor.
    """

    id: str
    edge: str
    index: int
    points: Float[np.ndarray, "points 3"]
    width: float
    speed_limit: float
    junction: str | None
    successors: tuple[str, ...]
    left: str | None
    right: str | None
    acceleration: bool = False

    @cached_property
    def along(self) -> Float[np.ndarray, " points"]:
        """Arc length of each point (of x and y)."""
        return arc_lengths(self.points[:, :2])

    @property
    def length(self) -> float:
        """Length of the centre line in metres; SUMO's own `length` may differ by some percent."""
        return float(self.along[-1])


@dataclass(frozen=True)
class Link:
    """A connection of two lanes through a junction.

    Attributes:
        source: The incoming lane's id.
        target: The outgoing lane's id.
        via: The internal lanes between them, in order; empty where two edges just join.
        junction: The junction's id.
        turn: "straight", "left" or "right" (SUMO's slight turns count as the turn they are).
        control: "signal", "major", "minor", "stop", "allway", "equal" (right before left) or
            "zipper".
        signal: The signal's id, None where there is none.
        signal_index: The link's index in the signal's state string, -1 where there is none.
    """

    source: str
    target: str
    via: tuple[str, ...]
    junction: str
    turn: str
    control: str
    signal: str | None = None
    signal_index: int = -1


@dataclass(frozen=True)
class Junction:
    """A place where edges meet.

    Attributes:
        id: Junction id.
        kind: "signal", "priority", "stop", "allway", "right_before_left", "roundabout", "zipper"
            or "joint" (edges just join, nothing to yield to).
        x: Metres.
        y: Metres.
        arms: Number of distinct roads that meet here.
        outline: Polygon, x, y.
    """

    id: str
    kind: str
    x: float
    y: float
    arms: int
    outline: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Area:
    """A polygon that is no driving lane, for pictures: "sidewalk", "crossing" or "walking area"."""

    kind: str
    outline: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Life:
    """Traffic, pedestrians and parked cars of a town.

    Attributes:
        mix: Share of each kind in the vehicle traffic, by the kind's name; they sum to 1.
        walkers_per_km: Pedestrians per kilometre of sidewalk.
        parking: Share of the quiet streets' sides along which cars are parked.
    """

    mix: dict[str, float]
    walkers_per_km: float = 0.0
    parking: float = 0.0


CARS_ONLY = Life({"car": 0.9, "van": 0.1})


@dataclass(frozen=True, eq=False)
class Town:
    """A town's road network; immutable.

    Attributes:
        name: The folder's name in `networks/`.
        lanes: Driving lanes by id, internal ones included, sidewalks and crossings not.
        links: All links through junctions.
        junctions: By id.
        signals: Signal id to the number of its links.
        roundabouts: The edges of each roundabout's ring.
        areas: Sidewalks and crossings.
        life: Traffic, pedestrians and parked cars.
    """

    name: str
    lanes: dict[str, Lane]
    links: tuple[Link, ...]
    junctions: dict[str, Junction]
    signals: dict[str, int]
    roundabouts: tuple[tuple[str, ...], ...] = ()
    areas: tuple[Area, ...] = ()
    life: Life = CARS_ONLY

    @cached_property
    def edges(self) -> dict[str, tuple[Lane, ...]]:
        """Edge id to its driving lanes from right to left; internal edges are left out."""
        found: dict[str, list[Lane]] = {}
        for lane in self.lanes.values():
            if lane.junction is None:
                found.setdefault(lane.edge, []).append(lane)
        return {
            edge: tuple(sorted(lanes, key=lambda lane: lane.index)) for edge, lanes in found.items()
        }

    @cached_property
    def links_from(self) -> dict[str, tuple[Link, ...]]:
        """Incoming lane id to the links that leave it."""
        found: dict[str, list[Link]] = {}
        for link in self.links:
            found.setdefault(link.source, []).append(link)
        return {source: tuple(links) for source, links in found.items()}

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the box around all lane centre lines, metres."""
        points = np.concatenate([lane.points[:, :2] for lane in self.lanes.values()])
        width, height = points.max(axis=0) - points.min(axis=0)
        return float(width), float(height)

    @property
    def lane_km(self) -> float:
        """Length of all driving lanes outside junctions, kilometres."""
        return sum(lane.length for lane in self.lanes.values() if lane.junction is None) / 1000.0

    def to_json(self) -> str:
        """Return the town as JSON text; equal towns give equal text."""
        payload = {
            "format": TOWN_FORMAT,
            "name": self.name,
            "lanes": [
                {
                    "id": lane.id,
                    "edge": lane.edge,
                    "index": lane.index,
                    "points": np.round(lane.points, 3).tolist(),
                    "width": lane.width,
                    "speed_limit": lane.speed_limit,
                    "junction": lane.junction,
                    "successors": list(lane.successors),
                    "left": lane.left,
                    "right": lane.right,
                    "acceleration": lane.acceleration,
                }
                for lane in self.lanes.values()
            ],
            "links": [vars(link) for link in self.links],
            "junctions": [vars(junction) for junction in self.junctions.values()],
            "signals": self.signals,
            "roundabouts": self.roundabouts,
            "areas": [vars(area) for area in self.areas],
            "life": vars(self.life),
        }
        return json.dumps(payload, separators=(",", ":")) + "\n"

    @classmethod
    def from_json(cls, text: str) -> "Town":
        """Read the text of `to_json`.

        Raises:
            InputError: The text is not a town of this format.
        """
        try:
            payload = parse_json(text)
            if payload["format"] != TOWN_FORMAT:
                message = (
                    f"Expected town format {TOWN_FORMAT}, got {payload['format']}: build it again."
                )
                raise InputError(message)
            TownPayload.model_validate(payload)
            lanes = [_lane(item) for item in payload["lanes"]]
            town = cls(
                name=payload["name"],
                lanes={lane.id: lane for lane in lanes},
                links=tuple(
                    Link(**{**item, "via": tuple(item["via"])}) for item in payload["links"]
                ),
                junctions={
                    item["id"]: Junction(**_outlined(item)) for item in payload["junctions"]
                },
                signals=dict(payload["signals"]),
                roundabouts=tuple(tuple(ring) for ring in payload["roundabouts"]),
                areas=tuple(Area(**_outlined(item)) for item in payload["areas"]),
                life=Life(**payload["life"]),
            )
            town.check_names()
        except (ValueError, KeyError, TypeError) as error:
            message = (
                f"Not a town file ({type(error).__name__}: {in_one_line(error)}). Run 'plant-bench "
                "towns build'."
            )
            raise InputError(message) from error
        return town

    def check_names(self) -> None:
        """Check that every id refers to an existing object.

        Raises:
            ValueError: One does not.
        """
        lanes = [
            name
            for lane in self.lanes.values()
            for name in (*lane.successors, lane.left, lane.right)
        ]
        lanes += [name for link in self.links for name in (link.source, link.target, *link.via)]
        junctions = [item.junction for item in (*self.lanes.values(), *self.links)]
        lights = [link for link in self.links if link.signal is not None]
        unknown = {
            "lanes": {name for name in lanes if name is not None} - set(self.lanes),
            "junctions": {name for name in junctions if name is not None} - set(self.junctions),
            "signals": {
                f"{link.signal}/{link.signal_index}"
                for link in lights
                if not 0 <= link.signal_index < self.signals.get(str(link.signal), 0)
            },
        }
        for what, names in unknown.items():
            if names:
                message = f"unknown {what} {', '.join(sorted(names)[:3])}"
                raise ValueError(message)


def _lane(item: dict) -> Lane:
    points = np.asarray(item["points"], dtype=float).reshape(-1, 3)
    return Lane(**{**item, "points": points, "successors": tuple(item["successors"])})


def _outlined(item: dict) -> dict:
    return {**item, "outline": tuple((x, y) for x, y in item["outline"])}


def town_file(name: str, also_in: Sequence[Path] = ()) -> Path:
    """Return the path of a town's JSON file, searched as by `data_files.town_dir`.

    Raises:
        InputError: There is no such town.
    """
    return town_dir(name, also_in) / "town.json"


def load_town(name: str, also_in: Sequence[Path] = ()) -> Town:
    """Read a town, searched as by `data_files.town_dir`.

    An unchanged file is read once and cached: towns are immutable.

    Raises:
        InputError: There is no such town, or its file is invalid.
    """
    path = town_file(name, also_in)
    try:
        status = path.stat()
        return _read_town(path, status.st_mtime_ns, status.st_size)
    except (InputError, OSError, ValueError) as error:
        message = f"Cannot use the town {path}: {in_one_line(error)}"
        raise InputError(message) from error


@lru_cache(maxsize=4)
def _read_town(path: Path, _changed: int, _size: int) -> Town:
    return Town.from_json(read_text(path))


def town_checksum(name: str, also_in: Sequence[Path] = ()) -> str:
    """Return the SHA-256 of a town's JSON and network files.

    Raises:
        InputError: There is no such town.
    """
    path = town_file(name, also_in)
    digest = hashlib.sha256(path.read_bytes())
    digest.update(path.with_name("town.net.xml").read_bytes())
    return digest.hexdigest()
