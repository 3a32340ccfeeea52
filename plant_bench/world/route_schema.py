"""What a route's JSON looks like: types, finite numbers and sizes, checked before it is used."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from plant_bench.world.hazard import HazardKind

LONGEST_ID = 100  # characters: ids are parts of file names
MOST_POINTS = 200_000  # of a route: 200 km
Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1e7, le=1e7)]
Whole = Annotated[int, Field(strict=True, ge=-(2**31), lt=2**63)]
Text = Annotated[str, Field(strict=True, max_length=1000)]
Id = Annotated[str, Field(strict=True, min_length=1, max_length=LONGEST_ID)]
Turn = Literal["straight", "left", "right"]
Values = Annotated[list[Number], Field(max_length=MOST_POINTS)]


class Strict(BaseModel):
    """Values that have these fields and no others."""

    model_config = ConfigDict(extra="forbid")


class PassagePayload(Strict):
    """As `Passage`."""

    junction: Text
    entry: Number
    exit: Number
    turn: Turn
    control: Text
    signal: Text | None = None
    signal_index: Whole = -1


class LaneChangePayload(Strict):
    """As `LaneChange`."""

    start: Number
    end: Number
    direction: Literal["left", "right"]


class HazardPayload(Strict):
    """As `Hazard`."""

    kind: HazardKind
    at: Number
    arm: Number
    seed: Whole
    parameters: dict[Text, Number] = {}


class RoutePayload(BaseModel):
    """As `Route`; other fields are left alone."""

    id: Id
    town: Id
    edges: list[Text]
    lanes: list[tuple[Text, Number, Number]]
    passages: list[PassagePayload]
    lane_changes: list[LaneChangePayload]
    manoeuvres: dict[Text, Whole]
    hazards: list[HazardPayload] = []
    points: Annotated[list[tuple[Number, Number]], Field(max_length=MOST_POINTS)]
    elevations: Values
    speed_limits: Values
