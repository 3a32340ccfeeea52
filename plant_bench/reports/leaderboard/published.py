"""Published results of the PlanT paper (CARLA), as the rows of a separate table."""

import math

from plant_bench.reports.leaderboard.rows import UNKNOWN, Row
from plant_bench.scoring.metrics import Spread
from plant_bench.sensing.inputs import Track

SOURCE = (
    "Renz et al., PlanT: Explainable Planning Transformers via Object-Level Representations, CoRL "
    "2022, Table 1 (Longest6 in CARLA, 3 evaluations)"
)
RFDS_SOURCE = "RFDS: its table of section 4.3"

_CAMERAS = ("camera", "lidar")
_RASTER = ("rasterised objects", "HD map")
_UNKNOWN_TIME = math.nan

_SCORES: tuple[str, ...] = (
    "driving_score",
    "route_completion",
    "infraction_score",
    "vehicle_collisions",
)
# Planner, track, inputs, mean and standard deviation of each of `_SCORES`, inference time in ms.
# The paper prints 0.60 as the deviation of TransFuser's infraction score.
_TABLE_1 = (
    ("LAV", Track.SENSORS, _CAMERAS, "32.74 1.45 70.36 3.14 0.51 0.02 0.84 0.11", _UNKNOWN_TIME),
    ("TransFuser", Track.SENSORS, _CAMERAS, "47.30 5.72 93.38 1.20 0.50 0.60 2.44 0.64", 101.24),
    (
        "PlanT w/ perception",
        Track.SENSORS,
        _CAMERAS,
        "57.66 5.01 88.20 0.94 0.65 0.06 0.97 0.09",
        37.61,
    ),
    (
        "Rule-based",
        Track.OBJECTS,
        ("objects", "route"),
        "38.00 1.64 29.09 2.12 0.84 0.00 0.64 0.07",
        _UNKNOWN_TIME,
    ),
    ("AIM-BEV", Track.OBJECTS, _RASTER, "45.06 1.68 78.31 1.12 0.55 0.01 1.67 0.16", 18.14),
    ("Roach", Track.OBJECTS, _RASTER, "55.27 1.43 88.16 1.52 0.62 0.02 0.76 0.07", 3.24),
    (
        "PlanCNN",
        Track.OBJECTS,
        ("rasterised objects", "rasterised route"),
        "77.47 1.34 94.53 2.59 0.81 0.03 0.43 0.05",
        28.94,
    ),
    (
        "PlanT",
        Track.OBJECTS,
        ("objects", "route"),
        "81.36 6.54 93.55 2.62 0.87 0.05 0.31 0.12",
        10.79,
    ),
    (
        "Expert",
        Track.PRIVILEGED,
        ("objects", "route", "actions"),
        "76.91 2.23 88.67 0.56 0.86 0.03 0.28 0.06",
        _UNKNOWN_TIME,
    ),
)
_RFDS = {"PlanCNN": (Spread(82.83, 6.79), "masking"), "PlanT": (Spread(96.82, 2.12), "attention")}


def paper_rows() -> tuple[Row, ...]:
    """Return the rows of PlanT's Table 1, the highest driving score first."""
    rows = [_row(*row) for row in _TABLE_1]
    return tuple(sorted(rows, key=lambda row: -row.driving_score.mean))


def _row(
    planner: str, track: Track, inputs: tuple[str, ...], figures: str, inference_ms: float
) -> Row:
    values = [float(text) for text in figures.split()]
    spreads = [Spread(*pair) for pair in zip(values[::2], values[1::2], strict=True)]
    scores = dict(zip(_SCORES, spreads, strict=True))
    rfds, ranker = _RFDS.get(planner, (UNKNOWN, ""))
    return Row(
        id=f"paper-{planner.lower().replace('/', '').replace(' ', '-')}",
        planner=planner,
        track=track.label,
        inputs=inputs,
        scores=scores,
        inference_ms=inference_ms,
        rfds=rfds,
        ranker=ranker,
        repetitions=3,
        source=f"{SOURCE}; {RFDS_SOURCE}" if ranker else SOURCE,
    )
