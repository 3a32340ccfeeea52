"""Routes, suites of routes on disk, and scenarios."""

import hashlib
import json
import re
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Float

from plant_bench.data_files import routes_dir, town_dir, towns_dirs_of
from plant_bench.errors import InputError, in_one_line
from plant_bench.geometry.polyline import arc_lengths
from plant_bench.untrusted_files import read_json
from plant_bench.world.hazard import Hazard
from plant_bench.world.route_schema import RoutePayload
from plant_bench.world.town import Town, load_town, town_checksum

ROUTE_FORMAT = 1
_ID = re.compile(r"[A-Za-z0-9][\w.-]*")
PROTOCOL = "longest6-sumo-v2-rc2"  # docs/reference/protocol.md; not comparable with other protocols
NO_HAZARDS_PROTOCOL = f"{PROTOCOL}-no-hazards"


@dataclass(frozen=True)
class Passage:
    """The route's path through one junction.

    Attributes:
        junction: Junction id.
        entry: Arc length of the stop line, metres.
        exit: Arc length where the junction is left.
        turn: "straight", "left" or "right".
        control: As in `Link.control`.
        signal: Signal id, None where there is none.
        signal_index: The link's place in the signal's state, -1 where there is none.
    """

    junction: str
    entry: float
    exit: float
    turn: str
    control: str
    signal: str | None = None
    signal_index: int = -1


@dataclass(frozen=True)
class LaneSpan:
    """A lane and the stretch of the route on it; a lane change belongs to its target lane."""

    lane: str
    start: float
    end: float


@dataclass(frozen=True)
class LaneChange:
    """A lane change of the route: arc lengths of its start and end; "left" or "right"."""

    start: float
    end: float
    direction: str


@dataclass(frozen=True, eq=False)
class Route:
    """A lane-level route.

    Attributes:
        id: Unique in its suite, for instance "town01-0".
        town: Town name.
        points: Centre line every metre, x, y, from the start to the destination (box centres).
        elevations: z of each point, metres; distinguishes levels where roads cross.
        speed_limits: m/s at each point: the posted limit, or what the lane's curvature allows.
        edges: SUMO edges in order, one beyond the destination included where the town allows.
        lanes: The lanes in order.
        passages: The junctions in order.
        lane_changes: In order.
        manoeuvres: Number of each manoeuvre: left, right, straight, lane_change, roundabout, merge,
            exit, u_turn.
        hazards: Hazards in order.
        town_folders: Folders to search for its town besides `networks/`; not part of the
            route's content.
    """

    id: str
    town: str
    points: Float[np.ndarray, "points 2"]
    elevations: Float[np.ndarray, " points"]
    speed_limits: Float[np.ndarray, " points"]
    edges: tuple[str, ...]
    lanes: tuple[LaneSpan, ...]
    passages: tuple[Passage, ...]
    lane_changes: tuple[LaneChange, ...]
    manoeuvres: dict[str, int]
    hazards: tuple[Hazard, ...] = ()
    town_folders: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        """Make the arrays read-only, because planners get them without a copy."""
        for values in (self.points, self.elevations, self.speed_limits):
            values.flags.writeable = False

    @cached_property
    def along(self) -> Float[np.ndarray, " points"]:
        """Arc length of each point."""
        return _locked(arc_lengths(self.points))

    @cached_property
    def headings(self) -> Float[np.ndarray, " points"]:
        """Heading at each point, unwrapped (central differences)."""
        delta = np.gradient(self.points, axis=0)
        return _locked(np.unwrap(np.arctan2(delta[:, 1], delta[:, 0])))

    @property
    def plan(self) -> "Route":
        """The route as planners get it: without hazards."""
        return replace(self, hazards=()) if self.hazards else self

    def load_town(self) -> Town:
        """Read the route's town, as `plant_bench.world.town.load_town`."""
        return load_town(self.town, self.town_folders)

    @property
    def town_dir(self) -> Path:
        """The folder of the route's town.

        Raises:
            InputError: There is no such town.
        """
        return town_dir(self.town, self.town_folders)

    @property
    def town_checksum(self) -> str:
        """The content hash of the route's town; as `plant_bench.world.town.town_checksum`."""
        return town_checksum(self.town, self.town_folders)

    @property
    def length(self) -> float:
        """Metres."""
        return float(self.along[-1])

    @cached_property
    def signal_passages(self) -> tuple[Passage, ...]:
        """The passages that have a traffic light, in order; `Scene.lights` follows them."""
        return tuple(passage for passage in self.passages if passage.signal is not None)

    @cached_property
    def signal_entries(self) -> tuple[float, ...]:
        """Arc lengths of the stop lines that have a traffic light, rising."""
        return tuple(passage.entry for passage in self.signal_passages)

    def to_payload(self) -> dict:
        """Return the route as JSON-able values."""
        return {
            "id": self.id,
            "town": self.town,
            "edges": list(self.edges),
            "lanes": [[span.lane, span.start, span.end] for span in self.lanes],
            "passages": [vars(passage) for passage in self.passages],
            "lane_changes": [vars(change) for change in self.lane_changes],
            "manoeuvres": self.manoeuvres,
            "hazards": [hazard.to_payload() for hazard in self.hazards],
            "points": np.round(self.points, 3).tolist(),
            "elevations": np.round(self.elevations, 2).tolist(),
            "speed_limits": np.round(self.speed_limits, 2).tolist(),
        }

    @classmethod
    def from_payload(cls, payload: dict) -> "Route":
        """Read a payload of `to_payload`.

        Raises:
            InputError: Fields are missing or have the wrong shape, or values are not finite.
        """
        try:
            RoutePayload.model_validate(payload)
            route = cls(
                id=str(payload["id"]),
                town=str(payload["town"]),
                points=np.asarray(payload["points"], dtype=float),
                elevations=np.asarray(payload["elevations"], dtype=float),
                speed_limits=np.asarray(payload["speed_limits"], dtype=float),
                edges=tuple(payload["edges"]),
                lanes=tuple(LaneSpan(*item) for item in payload["lanes"]),
                passages=tuple(Passage(**item) for item in payload["passages"]),
                lane_changes=tuple(LaneChange(**item) for item in payload["lane_changes"]),
                manoeuvres=dict(payload["manoeuvres"]),
                hazards=tuple(map(Hazard.from_payload, payload.get("hazards", ()))),
            )
        except (KeyError, TypeError, ValueError) as error:
            message = f"Invalid route ({type(error).__name__}: {in_one_line(error)})."
            raise InputError(message) from error
        route.validate()
        return route

    def validate(self) -> None:
        """Check shapes and values.

        Raises:
            InputError: A shape or value is invalid.
        """
        count = len(self.points)
        if self.points.ndim != 2 or self.points.shape[1] != 2 or count < 2:
            message = f"Route {self.id}: expected points of shape (n, 2), got {self.points.shape}."
            raise InputError(message)
        if len(self.elevations) != count or len(self.speed_limits) != count:
            message = f"Route {self.id}: elevations and speed limits must have one value per point."
            raise InputError(message)
        values = (self.points, self.elevations, self.speed_limits)
        if not all(np.isfinite(value).all() for value in values):
            message = f"Route {self.id}: some values are not finite."
            raise InputError(message)
        spacing = np.diff(self.along)
        if spacing.min() < 0.2 or spacing.max() > 2.0:
            message = (
                f"Route {self.id}: expected points about 1 m apart, got "
                f"{spacing.min():.2f} to {spacing.max():.2f} m."
            )
            raise InputError(message)
        spans = [(item.start, item.end) for item in (*self.lanes, *self.lane_changes)]
        spans += [(item.entry, item.exit) for item in self.passages]
        entries = [item.entry for item in self.passages]
        if entries != sorted(entries) or any(start > end for start, end in spans):
            message = (
                f"Route {self.id}: a lane, lane change or junction ends before it starts, "
                "or junctions are not in order."
            )
            raise InputError(message)
        if not self.edges or not self.lanes or self.speed_limits.min() <= 0.0:
            message = f"Route {self.id}: expected edges, lanes and positive speed limits."
            raise InputError(message)

    def check_town(self, town: Town) -> None:
        """Check that the route can be driven in a town.

        Raises:
            InputError: It refers to edges, lanes or signals that the town does not have.
        """
        named = {
            "town": {self.town} - {town.name},
            "edges": set(self.edges) - set(town.edges),
            "lanes": {span.lane for span in self.lanes} - set(town.lanes),
            "signals": {str(item.signal) for item in self.signal_passages} - set(town.signals),
        }
        for passage in self.signal_passages:
            if not 0 <= passage.signal_index < town.signals.get(str(passage.signal), 0):
                named["signals"].add(f"{passage.signal}/{passage.signal_index}")
        for what, unknown in named.items():
            if unknown:
                some = ", ".join(sorted(unknown)[:3])
                message = f"Route {self.id}: {what} {some} not in {town.name}."
                raise InputError(message)

    @cached_property
    def checksum(self) -> str:
        """SHA-256 of the route's content."""
        text = json.dumps(self.to_payload(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class Scenario:
    """Everything that an episode depends on: route, traffic density, seed and hazards.

    Attributes:
        route: The route to drive.
        seed: Seed of the traffic and SUMO.
        density: A name of `plant_bench.sim.densities.DENSITIES`.
        hazards: Whether the route's hazards are active.
    """

    route: Route
    seed: int
    density: str = "dense"
    hazards: bool = True

    @property
    def protocol(self) -> str:
        """Name of the protocol."""
        return PROTOCOL if self.hazards else NO_HAZARDS_PROTOCOL

    @property
    def played_hazards(self) -> tuple[Hazard, ...]:
        """The hazards of this scenario."""
        return self.route.hazards if self.hazards else ()

    @property
    def key(self) -> str:
        """A short content hash that identifies the scenario."""
        text = f"{self.protocol}|{self.route.checksum}|{self.seed}|{self.density}"
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def suite_names() -> list[str]:
    """Return the suites in `routes/`."""
    return sorted(path.name for path in routes_dir().iterdir() if any(path.glob("*.json")))


def load_suite(name: str) -> list[Route]:
    """Read a suite by its name in `routes/`, or a folder or file of routes.

    Its routes also find towns in a folder `towns` in it or beside it.

    Raises:
        InputError: There is no such suite, or one of its files is invalid.
    """
    path = Path(name)
    if not path.exists():
        path = routes_dir() / name
    if not path.exists():
        message = f"There is no suite '{name}'. Available suites: {', '.join(suite_names())}."
        raise InputError(message)
    towns = towns_dirs_of(path if path.is_dir() else path.parent)
    folders = tuple(folder for folder in towns if folder.is_dir())
    files = sorted(path.glob("*.json")) if path.is_dir() else [path]
    routes = [replace(route, town_folders=folders) for file in files for route in _load_file(file)]
    if len({route.id for route in routes}) < len(routes) or not all(
        _ID.fullmatch(route.id) for route in routes
    ):
        message = (
            f"Route ids in {path} must be unique, with letters, digits, '.', '_' and '-' only."
        )
        raise InputError(message)
    if not routes:
        message = f"No routes (*.json) found in {path}."
        raise InputError(message)
    return routes


def _locked(values: np.ndarray) -> np.ndarray:
    values.flags.writeable = False
    return values


def _load_file(path: Path) -> list[Route]:
    try:
        payload = read_json(path)
        if not isinstance(payload, dict) or payload.get("format") != ROUTE_FORMAT:
            message = f"expected a file of route format {ROUTE_FORMAT}"
            raise InputError(message)
        return [Route.from_payload(item) for item in payload["routes"]]
    except (InputError, ValueError, KeyError, TypeError, OSError) as error:
        message = f"Cannot use the routes file {path}: {in_one_line(error).rstrip('.')}."
        raise InputError(message) from error
