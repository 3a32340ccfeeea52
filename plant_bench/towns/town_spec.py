"""Data model of town specs, and the reader of `networks/<town>/spec.toml`."""

import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from plant_bench.errors import InputError, in_one_line
from plant_bench.untrusted_files import read_text

VEHICLE_KINDS = ("car", "van", "truck", "bus", "motorcycle", "bicycle")

UnsignalledControl = Literal["priority", "priority_stop", "allway_stop", "right_before_left"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class RoadClass(_Part):
    """Lanes per direction, speed limit and sidewalks of one class of road."""

    lanes: int = Field(ge=1, le=5)
    speed_kmh: float = Field(ge=20, le=130)
    sidewalk: bool = False

    @property
    def speed(self) -> float:
        """The speed limit in m/s, cut (not rounded) to SUMO's two decimals."""
        return int(self.speed_kmh / 3.6 * 100 + 1e-9) / 100


class Signals(_Part):
    """Programs of the traffic lights; times in seconds."""

    program: Literal["actuated", "static"] = "actuated"
    cycle: float = Field(default=60, ge=30, le=120)
    yellow: float = Field(default=3, ge=2, le=6)
    all_red: float = Field(default=2, ge=1, le=4)


class Junctions(_Part):
    """Corner radius of junctions, and the right-of-way rule of those without signals."""

    radius: float = Field(default=8, ge=5, le=20)
    unsignalled: UnsignalledControl = "priority_stop"


class TownLife(_Part):
    """Mix of the vehicle traffic, pedestrians and parked cars.

    Pedestrians walk on sidewalks; cars are parked along streets of at most 30 km/h.
    """

    car: float = Field(default=0.9, ge=0, le=1)
    van: float = Field(default=0.1, ge=0, le=1)
    truck: float = Field(default=0, ge=0, le=1)
    bus: float = Field(default=0, ge=0, le=1)
    motorcycle: float = Field(default=0, ge=0, le=1)
    bicycle: float = Field(default=0, ge=0, le=1)
    walkers_per_km: float = Field(default=0, ge=0, le=100, description="of sidewalk")
    parking: float = Field(default=0, ge=0, le=1, description="share of the streets' sides")

    @property
    def mix(self) -> dict[str, float]:
        """Share of each kind in the vehicle traffic."""
        return {kind: getattr(self, kind) for kind in VEHICLE_KINDS}

    @model_validator(mode="after")
    def _shares_sum_to_one(self) -> "TownLife":
        total = sum(self.mix.values())
        if abs(total - 1.0) > 1e-6:
            message = f"the shares of {', '.join(VEHICLE_KINDS)} sum to {total:.3f}, expected 1"
            raise ValueError(message)
        return self


class SmallTownLayout(_Part):
    """Rows of streets joined by staggered cross streets: T-junctions only."""

    character: Literal["small_town"]
    rows: int = Field(ge=3, le=8)
    links_per_band: tuple[int, int]
    spacing_min: float = Field(ge=40)
    jitter: float = Field(ge=0, le=20)
    corner_radius: float = Field(ge=18, le=80)
    signalled: int = Field(ge=0)


class LatticeLayout(_Part):
    """A grid of streets, some of them avenues, with some streets omitted."""

    character: Literal["lattice"]
    columns: int = Field(ge=3, le=10)
    rows: int = Field(ge=3, le=10)
    jitter: float = Field(ge=0, le=20)
    missing: int = Field(ge=0, description="number of inner streets to omit")
    avenues: int = Field(default=0, ge=0, description="inner streets of class `avenue`")
    corner_radius: float = Field(ge=18, le=80)
    unsignalled: int = Field(default=0, ge=0, description="junctions without lights")


class LargeTownLayout(_Part):
    """A town of avenues and side streets around a roundabout and a five-way junction."""

    character: Literal["large_town"]
    jitter: float = Field(ge=0, le=15)
    corner_radius: float = Field(ge=25, le=80)
    ring_radius: float = Field(ge=22, le=40)
    five_way_radius: float = Field(default=14, ge=12, le=20)


class FigureEightLayout(_Part):
    """A figure-eight highway whose larger loop surrounds a small town."""

    character: Literal["figure_eight"]
    town_radius: float = Field(ge=200, description="of the loop around the town")
    far_radius: float = Field(ge=90)
    tilt_deg: float = Field(ge=20, le=60, description="of the line between the loops' centres")
    block: float = Field(ge=80, description="length of the town's blocks")
    clearance: float = Field(default=7, ge=6, le=9)
    median: float = Field(default=4, ge=2)
    ramp_lane: float = Field(default=120, ge=80, description="acceleration lanes' length")
    jitter: float = Field(ge=0, le=15)


class LongHighwayLayout(_Part):
    """Two long highways joined to a ring, a road between them, ramps, U-turns and service roads."""

    character: Literal["long_highway"]
    bend_radius: float = Field(ge=90)
    median: float = Field(ge=12)
    ramp_lane: float = Field(default=120, ge=80, description="acceleration lanes' length")
    ramp_pairs: int = Field(ge=2, le=4)
    u_turns: int = Field(ge=2, le=4)
    services: int = Field(ge=0, le=2)
    jitter: float = Field(ge=0, le=30)


Layout = Annotated[
    SmallTownLayout | LatticeLayout | LargeTownLayout | FigureEightLayout | LongHighwayLayout,
    Field(discriminator="character"),
]


class Requirements(_Part):
    """Minimums that the generated town must contain; counted in its network."""

    signalled_t_junctions: int = 0
    signalled_crossroads: int = 0
    signalled: int = 0
    unsignalled: int = 0
    large_junctions: int = Field(default=0, description="junctions of five arms or more")
    roundabouts: int = 0
    on_ramps: int = 0
    off_ramps: int = 0
    u_turns: int = 0
    multi_lane_km: float = Field(default=0, description="lane-km on edges of two lanes or more")
    curves: int = Field(default=0, description="edges that turn by 45 degrees or more")
    bridges: int = Field(default=0, description="places where edges cross at two levels")


class TownSpec(_Part):
    """Specification of a town; another seed gives another town of the same character."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$")
    description: str
    seed: int = Field(ge=0)
    extent: tuple[float, float]
    lane_width: float = Field(default=3.5, ge=2.8, le=4)
    roads: dict[str, RoadClass]
    junctions: Junctions = Junctions()
    signals: Signals = Signals()
    life: TownLife = TownLife()
    layout: Layout
    requires: Requirements = Requirements()

    def road(self, name: str) -> RoadClass:
        """The road class of that name."""
        if name not in self.roads:
            raise InputError(
                f"The spec of {self.name} has no road class {name!r}, only "
                f"{', '.join(self.roads)}. Add a table [roads.{name}]."
            )
        return self.roads[name]


def read_spec(path: Path) -> TownSpec:
    """Read and check a `spec.toml`."""
    if not path.is_file():
        raise InputError(
            f"There is no town spec {path}: expected a spec.toml in the town's folder."
        )
    try:
        return TownSpec.model_validate(tomllib.loads(read_text(path)))
    except (OSError, ValueError, RecursionError) as error:
        message = f"Invalid town spec: {path} ({in_one_line(error)})."
        raise InputError(message) from error
