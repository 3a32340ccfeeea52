"""The table of hazards, one row per kind: texts, placement, parameters and behaviour class.

A new kind needs a row here and a behaviour in `sim.hazards`; docs/how-to/add-a-hazard.md shows how.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from typing import Any, NamedTuple

from plant_bench.errors import InputError
from plant_bench.world import hazard_sketch as draw
from plant_bench.world.hazard_sketch import BESIDE, NEAR, Box, Sketch, person

BEHAVIOURS, PLACES = "plant_bench.sim.hazards", "plant_bench.towns.hazard_places"
NUMBERS, PATHS = "plant_bench.towns.hazard_numbers", "plant_bench.world.conflicting_paths"


class Arm(NamedTuple):
    """How far before its place a hazard is armed.

    Attributes:
        time: Driving time at the speed limit, seconds.
        nearest: Minimum distance, metres.
        farthest: Maximum distance, metres.
        whole: Whether the route must have the full distance; else it is cut off at the start.
        unseen: Whether the place must then be out of the ego's sight.
    """

    time: float
    nearest: float
    farthest: float
    whole: bool = True
    unseen: bool = False


NEAR_BY = Arm(10.0, 90.0, 140.0, whole=False)
SENT_AHEAD = Arm(11.0, 130.0, 220.0)  # a vehicle is spawned 90 m ahead, and waits
BESIDE_EGO = Arm(9.0, 100.0, 180.0)  # vehicles get into place beside the ego
OUT_OF_SIGHT = Arm(12.0, 140.0, 240.0, unseen=True)  # spawned beyond the ego's sight


@dataclass(frozen=True, kw_only=True)
class HazardRow:
    """Everything about a kind of hazard except its behaviour.

    A "module:name" is imported on first use, because its package depends on this one.

    Attributes:
        letter: Label on pictures.
        carla: Scenario type of the CARLA leaderboard that it corresponds to, or None.
        sentence: Description for users.
        sketch: Its picture.
        behaviour: "module:Class" of its `HazardBehaviour`.
        every_tick: Whether it must be stepped at every tick while armed, to place a vehicle.
        where: "module:function" that finds its places on a route; kinds may share one.
        fits: "module:function" with which `where` tells kinds apart; "" if not needed.
        arm: How far before its place it is armed.
        spread: Half range of a random offset of its place, metres.
        kept_free: Radius around its place without parked cars, metres; for hazards that place
            actors beside the road or perturb the steering.
        weight: Weight in the draw while it has a place left; kinds with rare places weigh more.
        ranges: Minimum and maximum of the parameters drawn for each hazard, SI units, by name.
        numbers: "module:function" that draws parameters that depend on the place; "" if none.
    """

    letter: str
    carla: int | None
    sentence: str
    sketch: Sketch
    behaviour: str
    every_tick: bool = False
    where: str
    fits: str = ""
    arm: Arm = NEAR_BY
    spread: float = 0.0
    kept_free: float = 0.0
    weight: float
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    numbers: str = ""


class HazardKind(StrEnum):
    """The kinds of hazards in the order of listing; `HAZARDS` has their rows."""

    _value_: str
    row: HazardRow

    def __new__(cls, value: str, row: HazardRow) -> "HazardKind":  # noqa: PYI034  beartype checks no Self
        """Make the kind of a row."""
        kind = str.__new__(cls, value)
        kind._value_, kind.row = value, row
        return kind

    CONTROL_LOSS = (
        "control_loss",
        HazardRow(
            letter="S",
            carla=1,
            sentence="For a moment, grip is low and the ego's steering is pulled to both sides.",
            sketch=Sketch("street", draw.WAVES),
            behaviour=f"{BEHAVIOURS}.control_loss:ControlLoss",
            where=f"{PLACES}:off_junctions",
            kept_free=40.0,
            weight=9.0,
            numbers=f"{NUMBERS}:slip",
        ),
    )
    CROSSING = (
        "crossing",
        HazardRow(
            letter="X",
            carla=3,
            sentence="A pedestrian or cyclist crosses mid-block, maybe from behind a parked van.",
            sketch=Sketch(
                "street",
                draw.AHEAD,
                (
                    Box(9.0, -4.9, size=(5.3, 2.0), colour="parked"),
                    person(14.0, -6.0, 90.0, ((14.0, -5.0), (14.0, 6.5))),
                ),
            ),
            behaviour=f"{BEHAVIOURS}.crossing:Crossing",
            where=f"{PLACES}:at_kerbs",
            kept_free=15.0,
            weight=13.0,
            numbers=f"{NUMBERS}:crossing",
        ),
    )
    CROSSING_AFTER_TURN = (
        "crossing_after_turn",
        HazardRow(
            letter="A",
            carla=4,
            sentence="A pedestrian or cyclist crosses the street that the ego just turned into.",
            sketch=Sketch(
                "junction", draw.RIGHT, (person(2.6, -10.0, 0.0, ((3.6, -10.0), (14.0, -10.0))),)
            ),
            behaviour=f"{BEHAVIOURS}.crossing:Crossing",
            where=f"{PLACES}:behind_turns",
            spread=2.0,
            kept_free=15.0,
            weight=5.0,
            numbers=f"{NUMBERS}:open_crossing",
        ),
    )
    RED_LIGHT_RUNNER = (
        "red_light_runner",
        HazardRow(
            letter="R",
            carla=7,
            sentence="A crossing vehicle runs its red light while the ego has green.",
            sketch=Sketch(
                "junction",
                draw.AHEAD,
                (draw.NORTHWARD,),
                ((2.6, -5.6, "green"), (12.6, -5.6, "red")),
            ),
            behaviour=f"{BEHAVIOURS}.junction_conflict:JunctionConflict",
            where=f"{PLACES}:at_junctions",
            fits=f"{PATHS}:crosses",
            weight=8.0,
        ),
    )
    UNPROTECTED_LEFT = (
        "unprotected_left",
        HazardRow(
            letter="L",
            carla=8,
            sentence="Oncoming vehicles with varying gaps while the ego turns left on green.",
            sketch=Sketch(
                "junction",
                draw.LEFT,
                (
                    Box(20.0, BESIDE, 180.0, ((17.0, BESIDE), (-28.0, BESIDE))),
                    Box(31.0, BESIDE, 180.0),
                ),
                ((2.6, -5.6, "green"), (13.4, 5.6, "green")),
            ),
            behaviour=f"{BEHAVIOURS}.unprotected_left:UnprotectedLeft",
            where=f"{PLACES}:at_junctions",
            fits=f"{PATHS}:is_oncoming",
            weight=26.0,
        ),
    )
    RIGHT_TURN = (
        "right_turn",
        HazardRow(
            letter="T",
            carla=9,
            sentence=("A vehicle comes from the left (at lights on red) as the ego turns right."),
            sketch=Sketch(
                "junction", draw.RIGHT, (Box(6.25, 13.0, -90.0, ((6.25, 10.0), (6.25, -8.0))),)
            ),
            behaviour=f"{BEHAVIOURS}.junction_conflict:JunctionConflict",
            where=f"{PLACES}:at_junctions",
            fits=f"{PATHS}:joins_from_left",
            weight=16.0,
        ),
    )
    UNSIGNALLED_CROSSING = (
        "unsignalled_crossing",
        HazardRow(
            letter="U",
            carla=10,
            sentence="A vehicle arrives at the same time as the ego at a junction without lights.",
            sketch=Sketch("junction", draw.AHEAD, (draw.NORTHWARD,)),
            behaviour=f"{BEHAVIOURS}.junction_conflict:JunctionConflict",
            where=f"{PLACES}:at_junctions",
            fits=f"{PATHS}:is_unsignalled",
            weight=14.0,
        ),
    )
    HARD_BRAKE = (
        "hard_brake",
        HazardRow(
            letter="H",
            carla=None,
            sentence="The vehicle ahead brakes hard without a visible reason.",
            sketch=Sketch(
                "street",
                ((-14.0, NEAR), (2.0, NEAR)),
                (Box(8.0, NEAR, path=((11.0, NEAR), (15.0, NEAR))),),
            ),
            behaviour=f"{BEHAVIOURS}.hard_brake:HardBrake",
            where=f"{PLACES}:on_lanes",
            fits=f"{PLACES}:for_braking",
            arm=SENT_AHEAD,
            weight=5.0,
            ranges={"braking": (6.0, 8.0), "wait": (2.0, 4.0)},
        ),
    )
    CUT_IN = (
        "cut_in",
        HazardRow(
            letter="C",
            carla=None,
            sentence="A vehicle in the adjacent lane cuts in close ahead of the ego.",
            sketch=Sketch(
                "dual",
                draw.AHEAD,
                (
                    Box(
                        -8.0,
                        BESIDE,
                        path=((-5.0, BESIDE), (0.0, BESIDE), (10.0, NEAR), (16.0, NEAR)),
                    ),
                ),
            ),
            behaviour=f"{BEHAVIOURS}.cut_in:CutIn",
            every_tick=True,
            where=f"{PLACES}:on_lanes",
            fits=f"{PLACES}:for_cutting_in",
            arm=SENT_AHEAD,
            weight=12.0,
            ranges={"gap": (6.0, 8.0), "duration": (2.2, 2.5), "braking": (2.5, 3.5)},
        ),
    )
    BLOCKED_LANE = (
        "blocked_lane",
        HazardRow(
            letter="B",
            carla=None,
            sentence="A stationary van blocks the lane, and drives off after a while.",
            sketch=Sketch(
                "street",
                draw.STOPS,
                (
                    Box(10.0, NEAR),
                    Box(29.0, BESIDE, 180.0, ((26.0, BESIDE), (-20.0, BESIDE))),
                ),
            ),
            behaviour=f"{BEHAVIOURS}.blocked_lane:BlockedLane",
            where=f"{PLACES}:on_lanes",
            fits=f"{PLACES}:for_blocking",
            arm=OUT_OF_SIGHT,
            kept_free=15.0,
            weight=9.0,
            ranges={"wait": (15.0, 30.0)},
        ),
    )
    MERGE_PRESSURE = (
        "merge_pressure",
        HazardRow(
            letter="M",
            carla=None,
            sentence="A row of vehicles occupies the lane that the ego has to change to.",
            sketch=Sketch(
                "dual",
                ((-14.0, NEAR), (-2.0, NEAR), (14.0, BESIDE), (32.0, BESIDE)),
                tuple(
                    Box(x, BESIDE, path=((x + 3.0, BESIDE), (x + 8.0, BESIDE)))
                    for x in (-24.0, -11.0, 2.0)
                ),
            ),
            behaviour=f"{BEHAVIOURS}.merge_pressure:MergePressure",
            where=f"{PLACES}:at_lane_changes",
            arm=BESIDE_EGO,
            weight=9.0,
        ),
    )
    QUEUE_TAIL = (
        "queue_tail",
        HazardRow(
            letter="Q",
            carla=None,
            sentence="The ego approaches the tail of a slow or stationary queue.",
            sketch=Sketch(
                "dual",
                draw.STOPS,
                tuple(
                    Box(x, NEAR, path=((x + 2.6, NEAR), (x + 4.6, NEAR))) for x in (9.0, 17.0, 25.0)
                ),
            ),
            behaviour=f"{BEHAVIOURS}.queue_tail:QueueTail",
            where=f"{PLACES}:on_lanes",
            fits=f"{PLACES}:for_queues",
            arm=OUT_OF_SIGHT,
            weight=4.0,
            ranges={"wait": (12.0, 18.0), "pause": (1.5, 3.0)},
            numbers=f"{NUMBERS}:queue",
        ),
    )


HAZARDS: dict[HazardKind, HazardRow] = {kind: kind.row for kind in HazardKind}


def load_part(kind: HazardKind, column: str) -> Any:
    """Return the class or function that a kind's row names as "module:name".

    Args:
        kind: Kind of hazard.
        column: Field of the row: "behaviour", "where", "fits" or "numbers".

    Raises:
        InputError: It cannot be imported.
    """
    name = getattr(HAZARDS[kind], column)
    module, _, attribute = name.partition(":")
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, ValueError, AttributeError) as error:
        message = (
            f"The hazard '{kind}' has no {column}: its row in world/hazard_table.py names "
            f"'{name}', which cannot be imported ({error}). Add it, or correct the row."
        )
        raise InputError(message) from error
