"""Pydantic schema of a route's JSON: types, finite numbers and size limits."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from plant_bench.world.hazard import HazardKind

MAX_ID_LENGTH = 100  # characters: ids are parts of file names
MAX_POINTS = 200_000  # per route: 200 km
Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1e7, le=1e7)]
Whole = Annotated[int, Field(strict=True, ge=-(2**31), lt=2**63)]
Text = Annotated[str, Field(strict=True, max_length=1000)]
Id = Annotated[str, Field(strict=True, min_length=1, max_length=MAX_ID_LENGTH)]
Turn = Literal["straight", "left", "right"]
Values = Annotated[list[Number], Field(max_length=MAX_POINTS)]


class Strict(BaseModel):
    """Base of models that forbid extra fields."""

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
    """As `Route`; other fields are ignored."""

    id: Id
    town: Id
    edges: list[Text]
    lanes: list[tuple[Text, Number, Number]]
    passages: list[PassagePayload]
    lane_changes: list[LaneChangePayload]
    manoeuvres: dict[Text, Whole]
    hazards: list[HazardPayload] = []
    points: Annotated[list[tuple[Number, Number]], Field(max_length=MAX_POINTS)]
    elevations: Values
    speed_limits: Values
