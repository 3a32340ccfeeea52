"""Pydantic schema of a town's JSON: types and finite numbers."""

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from plant_bench.world.route_schema import Id, Number, Strict, Text, Turn, Whole

Positive = Annotated[float, Field(strict=True, gt=0.0, le=1e7, allow_inf_nan=False)]
Share = Annotated[float, Field(strict=True, ge=0.0, le=1e4, allow_inf_nan=False)]
Outline = list[tuple[Number, Number]]


class LanePayload(Strict):
    """As `Lane`."""

    id: Text
    edge: Text
    index: Whole
    points: Annotated[list[tuple[Number, Number, Number]], Field(min_length=2)]
    width: Positive
    speed_limit: Positive
    junction: Text | None
    successors: list[Text]
    left: Text | None
    right: Text | None
    acceleration: Annotated[bool, Field(strict=True)] = False


class LinkPayload(Strict):
    """As `Link`."""

    source: Text
    target: Text
    via: list[Text]
    junction: Text
    turn: Turn
    control: Text
    signal: Text | None = None
    signal_index: Whole = -1


class JunctionPayload(Strict):
    """As `Junction`."""

    id: Text
    kind: Text
    x: Number
    y: Number
    arms: Whole
    outline: Outline


class AreaPayload(Strict):
    """As `Area`."""

    kind: Text
    outline: Outline


class LifePayload(Strict):
    """As `Life`."""

    mix: dict[Text, Share]
    walkers_per_km: Share = 0.0
    parking: Share = 0.0


class TownPayload(BaseModel):
    """As `Town`; other fields are ignored."""

    format: Literal[2]
    name: Id
    lanes: Annotated[list[LanePayload], Field(min_length=1)]
    links: list[LinkPayload]
    junctions: list[JunctionPayload]
    signals: dict[Text, Annotated[int, Field(strict=True, ge=1, le=1000)]]
    roundabouts: list[list[Text]]
    areas: list[AreaPayload]
    life: LifePayload
