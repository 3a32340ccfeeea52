"""Vehicle types of the background traffic: real body sizes, each with three driver styles.

SUMO reads them from `vehicle_types.add.xml`, which `python -m plant_bench.sim.vehicle_types`
writes.
"""

import math
from dataclasses import dataclass
from pathlib import Path

from plant_bench.world.crossing_distance import RIDER_LENGTH, WALKER_LENGTH
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, ActorKind

TYPES_FILE = Path(__file__).with_name("vehicle_types.add.xml")
SLOWEST_FACTOR = 0.8  # times the speed limit: the lowest desired speed of a motor vehicle
SPEED_SPREAD = 0.2  # maximum excess of a driver's desired speed over its style's mean
STEEPEST_CHANGE = 0.4  # maximum lateral speed in a lane change, as a share of the speed


@dataclass(frozen=True)
class VehicleType:
    """A vehicle type: its SUMO id, size in metres, and share among the types of its kind.

    `top_speed` is in m/s; infinite if only the speed limit applies.
    """

    name: str
    length: float
    width: float
    kind: ActorKind
    share: float
    top_speed: float = math.inf


@dataclass(frozen=True)
class _Body:
    name: str
    length: float
    width: float
    kind: ActorKind
    share: float
    acceleration: float
    braking: float
    gap: float
    pace: float = 1.0
    top_speed: float = math.inf


@dataclass(frozen=True)
class _Style:
    """A driver style as SUMO parameters; none leads to red light violations or unsafe gaps."""

    suffix: str
    share: float
    pace: float
    spread: float
    headway: float
    extra_gap: float
    dawdling: float
    eagerness: float
    overtaking: float
    minor_gap: float


# Sizes are those of common European models; bus and truck are rigid.
_BODIES = (
    _Body("car_small", 3.97, 1.75, ActorKind.CAR, 0.33, 2.6, 4.5, 2.5),
    _Body("car_medium", 4.47, 1.84, ActorKind.CAR, 0.45, 2.6, 4.5, 2.5),
    _Body("car_large", 4.86, 1.92, ActorKind.CAR, 0.22, 2.6, 4.5, 2.5),
    _Body("van", 5.32, 2.01, ActorKind.VAN, 1.0, 2.6, 4.5, 2.5, pace=0.95),
    _Body("truck", 7.5, 2.45, ActorKind.TRUCK, 1.0, 1.3, 4.0, 2.5, pace=0.92, top_speed=23.0),
    _Body("bus", 9.0, 2.4, ActorKind.BUS, 1.0, 1.2, 4.0, 2.5, pace=0.92, top_speed=23.0),
    _Body("motorcycle", 2.2, 0.8, ActorKind.MOTORCYCLE, 1.0, 3.5, 5.0, 2.5),
    _Body("bicycle", 1.8, 0.65, ActorKind.BICYCLE, 1.0, 1.2, 3.0, 1.5, top_speed=6.36),
)
_STYLES = (
    _Style("_calm", 0.25, 0.92, 0.06, 1.4, 0.5, 0.4, 0.8, 0.5, 1.5),
    _Style("", 0.5, 1.0, 0.1, 1.0, 0.0, 0.5, 1.0, 1.0, 1.0),
    _Style("_hurried", 0.25, 1.1, 0.06, 0.8, -0.5, 0.5, 1.15, 2.0, 0.8),
)
_PLACED = """\
    <vType id="ego" vClass="passenger" length="{length:.2f}" width="{width:.2f}" height="1.51" \
minGap="2.5"/>
    <!-- Placed by hazards. Passenger class: SUMO maps it to a road lane, where drivers see it. -->
    <vType id="walker" vClass="passenger" length="{walker}" width="0.6" minGap="0.5"/>
    <vType id="rider" vClass="passenger" length="{rider}" width="0.65" minGap="0.5"/>
"""


def _type(body: _Body, style: _Style) -> VehicleType:
    return VehicleType(
        body.name + style.suffix, body.length, body.width, body.kind,
        body.share * style.share, round(body.top_speed * style.pace, 2),
    )  # fmt: skip


VEHICLE_TYPES = tuple(_type(body, style) for body in _BODIES for style in _STYLES)

# Spawned by hazards only, so without a share of the traffic.
WALKER = VehicleType("walker", WALKER_LENGTH, 0.6, ActorKind.PEDESTRIAN, 0.0)
RIDER = VehicleType("rider", RIDER_LENGTH, 0.65, ActorKind.BICYCLE, 0.0)
CAR = VehicleType("car_medium", 4.47, 1.84, ActorKind.CAR, 0.0)
VAN = VehicleType("van", 5.32, 2.01, ActorKind.VAN, 0.0)


def types_xml() -> str:
    """Return the text of `vehicle_types.add.xml`."""
    rows = "".join(_row(body, style) for body in _BODIES for style in _STYLES)
    placed = _PLACED.format(
        length=EGO_LENGTH, width=EGO_WIDTH, walker=WALKER_LENGTH, rider=RIDER_LENGTH
    )
    comment = "<!-- Written by plant_bench/sim/vehicle_types.py; edit that. -->"
    return f"{comment}\n<additional>\n{placed}{rows}</additional>\n"


def _row(body: _Body, style: _Style) -> str:
    """Return one type; all have the passenger class, which every driving lane allows."""
    made = _type(body, style)
    mean = body.pace * style.pace
    values = {
        "id": made.name,
        "vClass": "passenger",
        "length": f"{body.length:.2f}",
        "width": f"{body.width:.2f}",
        "minGap": f"{body.gap + style.extra_gap:.1f}",
        "accel": f"{body.acceleration * style.eagerness:.2f}",
        "decel": f"{body.braking:.1f}",
        "sigma": f"{style.dawdling:.1f}",
        "tau": f"{style.headway:.1f}",
        "speedFactor": f"normc({mean:.2f},{style.spread:.2f},{SLOWEST_FACTOR},"
        f"{mean + SPEED_SPREAD:.2f})",
        # No lateral motion at standstill: else SUMO leaves cars stationary across two lanes.
        "lcMaxSpeedLatStanding": "0.0",
        "lcMaxSpeedLatFactor": f"{STEEPEST_CHANGE}",
        "lcSpeedGain": f"{style.overtaking:.1f}",
        "jmTimegapMinor": f"{style.minor_gap:.1f}",
    }
    if math.isfinite(made.top_speed):
        values["maxSpeed"] = f"{made.top_speed:.2f}"
    attributes = " ".join(f'{key}="{value}"' for key, value in values.items())
    return f"    <vType {attributes}/>\n"


if __name__ == "__main__":
    TYPES_FILE.write_text(types_xml(), encoding="utf-8", newline="\n")
