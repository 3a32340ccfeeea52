"""Converts the records of a CARLA checkpoint file, and checks their consistency."""

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from pydantic import ValidationError

from plant_bench.reports.carla_checkpoint_schema import ALL_NAMES, OUTSIDE, Record
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import one_line

SCORE_TOLERANCE = 0.1  # between DS and RC x IS: forks round to three digits


@dataclass(frozen=True)
class ImportedRecord:
    """One episode of an imported run.

    Attributes:
        route: Route id: that of `original` if it exists, else the file's.
        repetition: From 0.
        town: Town name; empty if the file has none.
        status: How it ended, as in the file.
        driving_score: DS, 0 to 100.
        route_completion: RC in percent.
        infraction_score: IS, 0 to 1.
        counts: Number of infractions by the file's names, such as "collisions_vehicle".
        outside_km: Kilometres driven outside the lanes.
        route_km: Length of the route.
        km: Kilometres driven along it.
        duration: Simulated seconds.
        wall: Wall time in seconds; 0 if not known.
        original: The original plant-bench record; None in a file of another program.
    """

    route: str
    repetition: int
    town: str
    status: str
    driving_score: float
    route_completion: float
    infraction_score: float
    counts: Mapping[str, int]
    outside_km: float
    route_km: float
    km: float
    duration: float
    wall: float
    original: EpisodeResult | None = None


def imported_record(record: Record, seen: Counter[str]) -> ImportedRecord:
    """Convert a record; `seen` counts the repetitions of routes whose ids do not contain them.

    Raises:
        ValueError: It is inconsistent or incomplete.
    """
    if missing := [name for name in ALL_NAMES if name not in record.infractions]:
        message = f"its infractions lack {missing[0]}"
        raise ValueError(message)
    scores = record.scores
    product = scores.score_route * scores.score_penalty
    if abs(scores.score_composed - product) > SCORE_TOLERANCE:
        message = f"its driving score {scores.score_composed} is not RC x IS, {product:.3f}"
        raise ValueError(message)
    route, repetition = _place(record.route_id, seen)
    original = None if record.plant_bench is None else _original(record)
    completion = min(scores.score_route, 100.0)
    return ImportedRecord(
        route=route if original is None else original.route,
        repetition=repetition if original is None else original.repetition,
        town=(record.town_name or "") if original is None else original.town,
        status=record.status,
        driving_score=min(scores.score_composed, 100.0),
        route_completion=completion,
        infraction_score=scores.score_penalty,
        counts={name: len(texts) for name, texts in record.infractions.items()},
        outside_km=math.fsum(map(_outside_metres, record.infractions[OUTSIDE])) / 1000.0,
        route_km=record.meta.route_length / 1000.0,
        km=record.meta.route_length * completion / 100_000.0,
        duration=record.meta.duration_game,
        wall=record.meta.duration_system,
        original=original,
    )


def _place(route_id: str, seen: Counter[str]) -> tuple[str, int]:
    """Return a record's route and repetition; ids of leaderboard 1.0 contain the route only."""
    named = re.fullmatch(r"(.+)_rep(\d{1,6})", route_id, flags=re.DOTALL)
    if named:
        return named[1], int(named[2])
    seen[route_id] += 1
    return route_id, seen[route_id] - 1


def _original(record: Record) -> EpisodeResult:
    """Return the original plant-bench record.

    Raises:
        ValueError: It is broken, or differs from the rest of the record.
    """
    extra = record.plant_bench
    try:
        result = EpisodeResult.model_validate(None if extra is None else extra.result)
    except ValidationError as error:
        first = error.errors()[0]
        message = f"plant_bench.result.{'.'.join(map(str, first['loc']))}: {first['msg']}"
        raise ValueError(message) from error
    stated = (record.scores.score_composed, record.scores.score_route, record.scores.score_penalty)
    own = (result.driving_score, result.route_completion, result.infraction_score)
    if any(not math.isclose(*pair, abs_tol=1e-6) for pair in zip(stated, own, strict=True)):
        message = "its scores differ from those of its plant-bench record"
        raise ValueError(message)
    return result


def _outside_metres(text: str) -> float:
    """Return the metres in a message: its first number.

    Raises:
        ValueError: It contains no number.
    """
    found = re.search(r"\d{1,12}(?:\.\d+)?", text)
    if found is None:
        message = f"expected metres outside the lanes in {one_line(text)!r}, found no number"
        raise ValueError(message)
    return float(found[0])
