"""The table of hazards: a row a kind. Placing, playing, pages and pictures read it.

A new kind is a row here and a script in `sim.hazards`; docs/how-to/add-a-hazard.md shows it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from typing import Any, NamedTuple

from plant_bench.errors import InputError
from plant_bench.world import hazard_sketch as draw
from plant_bench.world.hazard_sketch import BESIDE, NEAR, Box, Sketch, person

SCRIPTS, PLACES = "plant_bench.sim.hazards", "plant_bench.towns.hazard_places"
NUMBERS, WAYS = "plant_bench.towns.hazard_numbers", "plant_bench.world.approaches"


class Arm(NamedTuple):
    """How long before its place a hazard may begin.

    Attributes:
        time: Seconds at the speed limit.
        nearest: Metres, at least.
        farthest: Metres, at most.
        whole: Whether the route must have all these metres; else they are cut off at its start.
        unseen: Whether the place must be out of the ego's sight then.
    """

    time: float
    nearest: float
    farthest: float
    whole: bool = True
    unseen: bool = False


NEAR_BY = Arm(10.0, 90.0, 140.0, whole=False)
SENT_AHEAD = Arm(11.0, 130.0, 220.0)  # one is sent 90 m ahead, and waits
BESIDE_EGO = Arm(9.0, 100.0, 180.0)  # vehicles get into place beside the ego
OUT_OF_SIGHT = Arm(12.0, 140.0, 240.0, unseen=True)  # put out beyond the ego's sight


@dataclass(frozen=True, kw_only=True)
class HazardRow:
    """All that there is to know of a kind of hazard, but how its script plays it.

    What is "module:name" is looked up when it is first asked for, since the rooms that hold it
    are above this one.

    Attributes:
        letter: Marks it on pictures.
        carla: The CARLA leaderboard's scenario type it mirrors, None beyond those.
        sentence: What happens.
        sketch: What its picture shows.
        script: "module:Class" of the `Script` that plays it.
        always_asked: Whether its script places a vehicle at every tick before it is committed.
        where: "module:function" that finds its places on a route; kinds may share one.
        fits: "module:function" by which `where` tells kinds apart; "" if it does not.
        arm: How long before its place it may begin.
        spread: Metres by which its place is drawn about the one found.
        kept_free: Metres around its place without parked cars: where it puts actors beside the
            road, or pulls the ego aside.
        weight: How likely it is drawn while it has a place left; rare places weigh more.
        ranges: Numbers drawn for each hazard, SI units: the least and the greatest by name.
        numbers: "module:function" that draws those that depend on the place; "" if none does.
    """

    letter: str
    carla: int | None
    sentence: str
    sketch: Sketch
    script: str
    always_asked: bool = False
    where: str
    fits: str = ""
    arm: Arm = NEAR_BY
    spread: float = 0.0
    kept_free: float = 0.0
    weight: float
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    numbers: str = ""


class HazardKind(StrEnum):
    """The benchmark's hazards, in the order in which they are listed. `HAZARDS` has their rows."""

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
            sentence="For a moment the road is slippery and the ego's wheels pull aside.",
            sketch=Sketch("street", draw.WAVES),
            script=f"{SCRIPTS}.control_loss:ControlLoss",
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
            sentence="A walker or rider crosses mid-block, also from behind a parked van.",
            sketch=Sketch(
                "street",
                draw.AHEAD,
                (
                    Box(9.0, -4.9, size=(5.3, 2.0), colour="parked"),
                    person(14.0, -6.0, 90.0, ((14.0, -5.0), (14.0, 6.5))),
                ),
            ),
            script=f"{SCRIPTS}.crossing:Crossing",
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
            sentence="A walker or rider crosses the street that the ego has just turned into.",
            sketch=Sketch(
                "junction", draw.RIGHT, (person(2.6, -10.0, 0.0, ((3.6, -10.0), (14.0, -10.0))),)
            ),
            script=f"{SCRIPTS}.crossing:Crossing",
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
            sentence="A vehicle from the side ignores its red light while the ego has green.",
            sketch=Sketch(
                "junction",
                draw.AHEAD,
                (draw.NORTHWARD,),
                ((2.6, -5.6, "green"), (12.6, -5.6, "red")),
            ),
            script=f"{SCRIPTS}.meeting:Meeting",
            where=f"{PLACES}:at_junctions",
            fits=f"{WAYS}:crosses",
            weight=8.0,
        ),
    )
    UNPROTECTED_LEFT = (
        "unprotected_left",
        HazardRow(
            letter="L",
            carla=8,
            sentence="Oncoming vehicles, with and without gaps, while the ego turns left on green.",
            sketch=Sketch(
                "junction",
                draw.LEFT,
                (
                    Box(20.0, BESIDE, 180.0, ((17.0, BESIDE), (-28.0, BESIDE))),
                    Box(31.0, BESIDE, 180.0),
                ),
                ((2.6, -5.6, "green"), (13.4, 5.6, "green")),
            ),
            script=f"{SCRIPTS}.unprotected_left:UnprotectedLeft",
            where=f"{PLACES}:at_junctions",
            fits=f"{WAYS}:is_oncoming",
            weight=26.0,
        ),
    )
    RIGHT_TURN = (
        "right_turn",
        HazardRow(
            letter="T",
            carla=9,
            sentence=(
                "A vehicle comes from the left (at lights against its red) as the ego turns right."
            ),
            sketch=Sketch(
                "junction", draw.RIGHT, (Box(6.25, 13.0, -90.0, ((6.25, 10.0), (6.25, -8.0))),)
            ),
            script=f"{SCRIPTS}.meeting:Meeting",
            where=f"{PLACES}:at_junctions",
            fits=f"{WAYS}:joins_from_left",
            weight=16.0,
        ),
    )
    UNSIGNALLED_CROSSING = (
        "unsignalled_crossing",
        HazardRow(
            letter="U",
            carla=10,
            sentence="A vehicle arrives together with the ego at a junction without lights.",
            sketch=Sketch("junction", draw.AHEAD, (draw.NORTHWARD,)),
            script=f"{SCRIPTS}.meeting:Meeting",
            where=f"{PLACES}:at_junctions",
            fits=f"{WAYS}:is_unsignalled",
            weight=14.0,
        ),
    )
    HARD_BRAKE = (
        "hard_brake",
        HazardRow(
            letter="H",
            carla=None,
            sentence="The vehicle ahead brakes hard for no visible reason.",
            sketch=Sketch(
                "street",
                ((-14.0, NEAR), (2.0, NEAR)),
                (Box(8.0, NEAR, path=((11.0, NEAR), (15.0, NEAR))),),
            ),
            script=f"{SCRIPTS}.hard_brake:HardBrake",
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
            sentence="A vehicle of the next lane changes closely in front of the ego.",
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
            script=f"{SCRIPTS}.cut_in:CutIn",
            always_asked=True,
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
            sentence="A van stands in the lane, and drives off after a wait.",
            sketch=Sketch(
                "street",
                draw.STOPS,
                (
                    Box(10.0, NEAR),
                    Box(29.0, BESIDE, 180.0, ((26.0, BESIDE), (-20.0, BESIDE))),
                ),
            ),
            script=f"{SCRIPTS}.blocked_lane:BlockedLane",
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
            sentence="The lane that the ego has to change to is taken by a row of vehicles.",
            sketch=Sketch(
                "dual",
                ((-14.0, NEAR), (-2.0, NEAR), (14.0, BESIDE), (32.0, BESIDE)),
                tuple(
                    Box(x, BESIDE, path=((x + 3.0, BESIDE), (x + 8.0, BESIDE)))
                    for x in (-24.0, -11.0, 2.0)
                ),
            ),
            script=f"{SCRIPTS}.merge_pressure:MergePressure",
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
            sentence="The ego comes upon the slow tail of a queue.",
            sketch=Sketch(
                "dual",
                draw.STOPS,
                tuple(
                    Box(x, NEAR, path=((x + 2.6, NEAR), (x + 4.6, NEAR))) for x in (9.0, 17.0, 25.0)
                ),
            ),
            script=f"{SCRIPTS}.queue_tail:QueueTail",
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
        kind: Of hazard.
        column: Of the row: "script", "where", "fits" or "numbers".

    Raises:
        InputError: There is no such thing.
    """
    name = getattr(HAZARDS[kind], column)
    module, _, attribute = name.partition(":")
    try:
        return getattr(import_module(module), attribute)
    except (ImportError, ValueError, AttributeError) as error:
        message = (
            f"The hazard '{kind}' has no {column}: its row in world/hazard_table.py names "
            f"'{name}', expected module:name ({error}). Write it, or correct the row."
        )
        raise InputError(message) from error
