"""Schema of the CARLA leaderboard's checkpoint file: names of infractions, pydantic models."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from plant_bench.scoring.infractions import InfractionKind

EXTRA_KEY = "plant_bench"  # for data that the schema lacks; other readers ignore it
EXTRA_FORMAT = 1
OUTSIDE = "outside_route_lanes"
STOP_SIGN = "stop_infraction"  # does not exist in this benchmark
NAMES: dict[InfractionKind, str] = {
    InfractionKind.COLLISION_STATIC: "collisions_layout",
    InfractionKind.COLLISION_PEDESTRIAN: "collisions_pedestrian",
    InfractionKind.COLLISION_VEHICLE: "collisions_vehicle",
    InfractionKind.OUTSIDE_LANES: OUTSIDE,
    InfractionKind.RED_LIGHT: "red_light",
    InfractionKind.ROUTE_DEVIATION: "route_dev",
    InfractionKind.TIMEOUT: "route_timeout",
    InfractionKind.BLOCKED: "vehicle_blocked",
}
ALL_NAMES = sorted([*NAMES.values(), STOP_SIGN])
RATE_LABELS: dict[str, str] = {  # in the file's order, after the three scores
    "collisions_pedestrian": "Collisions with pedestrians",
    "collisions_vehicle": "Collisions with vehicles",
    "collisions_layout": "Collisions with layout",
    "red_light": "Red lights infractions",
    STOP_SIGN: "Stop sign infractions",
    OUTSIDE: "Off-road infractions",
    "route_dev": "Route deviations",
    "route_timeout": "Route timeouts",
    "vehicle_blocked": "Agent blocked",
}
SCORE_LABELS = ("Avg. driving score", "Avg. route completion", "Avg. infraction penalty")
MOST_RECORDS = 1_000_000

_Seconds = Annotated[float, Field(ge=0.0)]


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True, extra="ignore", allow_inf_nan=False)


class Scores(_Part):
    """A record's scores; completion in percent, slightly above 100 if rounded."""

    score_composed: float = Field(ge=0.0, le=100.001)
    score_route: float = Field(ge=0.0, le=100.001)
    score_penalty: float = Field(ge=0.0, le=1.0)


class Meta(_Part):
    """A record's length in metres and durations in seconds."""

    route_length: float = Field(ge=0.0)
    duration_game: _Seconds
    duration_system: _Seconds = 0.0


class Extra(_Part):
    """The data that plant-bench adds to a record.

    Attributes:
        result: An `EpisodeResult`, as JSON.
    """

    result: dict[str, object]


class Record(_Part):
    """One episode; optional fields are those of leaderboard 2.x, Bench2Drive and other forks."""

    route_id: str
    status: str
    infractions: dict[str, list[str]]
    scores: Scores
    meta: Meta
    num_infractions: int | None = None
    scenario_name: str | None = None
    weather_id: int | str | None = None
    town_name: str | None = None
    plant_bench: Extra | None = None


class Progress(_Part):
    """Content of `_checkpoint`; the global record is recomputed from the records.

    Merged files (Bench2Drive's `merge_route_json.py`) have no `progress`.
    """

    progress: list[Annotated[int, Field(ge=0, le=MOST_RECORDS)]] = Field([], max_length=2)
    records: list[Record]


class Checkpoint(_Part):
    """A whole file."""

    checkpoint: Progress = Field(alias="_checkpoint")
    entry_status: str = ""
    merged_score: float | None = Field(None, alias="driving score")  # only merged files
    labels: list[str] = []
