"""Checkpoint files of the CARLA leaderboard as lines of a table of their own."""

from collections.abc import Iterable, Sequence

import numpy as np

from plant_bench.reports.carla_checkpoint import ImportedRecord, ImportedRun
from plant_bench.reports.carla_checkpoint_schema import NAMES
from plant_bench.reports.leaderboard.rows import Line
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.metrics import Spread
from plant_bench.scoring.normalised_score import LEAST_KM

VEHICLES = NAMES[InfractionKind.COLLISION_VEHICLE]
_SCORES = ("driving_score", "route_completion", "infraction_score")  # that each record tells
_KINDS = {name: kind.value for kind, name in NAMES.items()}


def imported_line(run: ImportedRun, *, id: str, planner: str) -> Line:
    """Return the line of a checkpoint file; rates are all counts over all kilometres."""
    numbers = sorted({item.repetition for item in run.records})
    parts = [[item for item in run.records if item.repetition == number] for number in numbers]
    return Line(
        id=id,
        planner=planner,
        track="",
        inputs=(),
        scores={name: _spread(parts, name) for name in _SCORES}
        | {"vehicle_collisions": Spread.of([_rate(part) for part in parts])},
        repetitions=len(parts),
        episodes=len(run.records),
        expected=run.expected,
        source=f"checkpoint file {run.source.name}",
        rates={_KINDS.get(name, name): rate for name, rate in run.infractions_per_km.items()},
        km=run.km,
    )


def _spread(parts: Iterable[Sequence[ImportedRecord]], name: str) -> Spread:
    return Spread.of([float(np.mean([getattr(item, name) for item in part])) for part in parts])


def _rate(part: Sequence[ImportedRecord]) -> float:
    hits = sum(item.counts.get(VEHICLES, 0) for item in part)
    return hits / max(sum(item.km for item in part), LEAST_KM)
