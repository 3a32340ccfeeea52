"""Leaderboard rows from result files ("checkpoints") of the CARLA leaderboard."""

from collections.abc import Iterable, Sequence

import numpy as np

from plant_bench.reports.carla_checkpoint import ImportedRecord, ImportedRun
from plant_bench.reports.carla_checkpoint_schema import NAMES
from plant_bench.reports.leaderboard.rows import Row
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.metrics import Spread
from plant_bench.scoring.normalised_score import LEAST_KM

VEHICLES = NAMES[InfractionKind.COLLISION_VEHICLE]
_SCORES = ("driving_score", "route_completion", "infraction_score")  # in each record
_KINDS = {name: kind.value for kind, name in NAMES.items()}


def imported_row(run: ImportedRun, *, id: str, planner: str, expected: int = 0) -> Row:
    """Return the row of a planner's files; a rate is the total count over the total kilometres.

    Args:
        run: The files' episodes.
        id: The row's id.
        planner: Display name.
        expected: Least number of episodes of a complete run, if the files do not know all routes.
    """
    numbers = sorted({item.repetition for item in run.records})
    parts = [[item for item in run.records if item.repetition == number] for number in numbers]
    return Row(
        id=id,
        planner=planner,
        track="",
        inputs=(),
        scores={name: _spread(parts, name) for name in _SCORES}
        | {"vehicle_collisions": Spread.of([_rate(part) for part in parts])},
        repetitions=len(parts),
        routes=len(run.route_lengths),
        episodes=len(run.records),
        expected=max(run.expected, expected),
        source=f"checkpoint file {run.source.name}",
        rates={_KINDS.get(name, name): rate for name, rate in run.infractions_per_km.items()},
        km=run.km,
    )


def _spread(parts: Iterable[Sequence[ImportedRecord]], name: str) -> Spread:
    return Spread.of([float(np.mean([getattr(item, name) for item in part])) for part in parts])


def _rate(part: Sequence[ImportedRecord]) -> float:
    hits = sum(item.counts.get(VEHICLES, 0) for item in part)
    return hits / max(sum(item.km for item in part), LEAST_KM)
