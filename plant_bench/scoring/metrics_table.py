"""The table of all metrics: names, units, descriptions, aggregation and where each is shown.

Reports, exports and documentation are generated from it, so that a metric is named here only.
An episode metric also has a function in `scoring.episode_metrics`; a metric of whole runs needs
only its row here. docs/how-to/add-a-metric.md shows how to add one. Records and episode keys do
not depend on this module.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from plant_bench.scoring.aggregation import (
    EpisodeValue,
    RunAggregate,
    km_per_km,
    mean,
    mean_score,
    measure_of,
    median,
    per_km,
    share_of_time,
)
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.normalised_score import counts_per_km, normalised_score
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult

RANKED = "driving_score"  # leaderboards are sorted by it, and differences in it are tested


class Better(StrEnum):
    """Which values of a metric are better."""

    HIGHER = "higher"
    LOWER = "lower"
    NEITHER = ""


class Shown(StrEnum):
    """Where a metric is shown. All are in `summary.json` and in the exports.

    Scores depend on the penalty scheme; they are reported with their standard deviation over
    repetitions, and by town. Measures are reported once, over all episodes.
    """

    HEADLINE = "headline"  # a score: in a run's table, and a column of every leaderboard
    SCORE = "score"  # a score: in a run's table
    MEASURE = "measure"  # below a run's table, and in the page's "Near misses and comfort"
    INFRACTION = "infraction"  # a measure: among the infractions per kilometre if not zero
    NOWHERE = "nowhere"  # a measure: only in `summary.json` and the exports


SCORES = (Shown.HEADLINE, Shown.SCORE)
LOWER, HIGHER, NEITHER = Better.LOWER, Better.HIGHER, Better.NEITHER


@dataclass(frozen=True)
class Metric:
    """A metric.

    Attributes:
        name: Name in summaries and exports.
        label: Short column header.
        unit: Such as "s" or "per km"; "share" is shown in percent if there is space.
        digits: Decimals shown.
        better: Which values are better.
        description: Definition, in a sentence or two.
        aggregate: How it is aggregated over a run.
        shown: Where it is shown.
        title: Long name; `label` if empty. Measures with the same title share a row of a run's
            table.
        column: Name of an episode's value, in `summary.csv` and, for measures, in records; empty
            if it is defined for runs only.
        episode: Value for one episode; None if it is defined for runs only.
    """

    name: str
    label: str
    unit: str
    digits: int
    better: Better
    description: str
    aggregate: RunAggregate
    shown: Shown
    title: str = ""
    column: str = ""
    episode: EpisodeValue | None = None

    @property
    def long_name(self) -> str:
        """The title, or the label if there is no title."""
        return self.title or self.label


def score_row(
    name: str,
    label: str,
    unit: str,
    digits: int,
    better: Better,
    aggregate: RunAggregate,
    description: str,
    *,
    episode: EpisodeValue | None = None,
    title: str = "",
    shown: Shown = Shown.HEADLINE,
) -> Metric:
    """Return the row of a score."""
    column = name if episode is not None else ""
    return Metric(
        name, label, unit, digits, better, description, aggregate, shown, title, column, episode
    )


def measure_row(
    measure: str,
    label: str,
    unit: str,
    digits: int,
    better: Better,
    aggregation: Callable[[str], RunAggregate],
    description: str,
    *,
    name: str = "",
    title: str = "",
    shown: Shown = Shown.MEASURE,
) -> Metric:
    """Return the row of a measure.

    Args:
        measure: Name in records, that of its function.
        label: As in `Metric`.
        unit: Unit of the run's value.
        digits: As in `Metric`.
        better: As in `Metric`.
        aggregation: A function of `scoring.aggregation`, such as `mean`.
        description: As in `Metric`.
        name: Name of the run's value, if it differs from `measure`.
        title: As in `Metric`.
        shown: As in `Metric`.
    """
    return Metric(
        name or measure,
        label,
        unit,
        digits,
        better,
        description,
        aggregation(measure),
        shown,
        title,
        measure,
        measure_of(measure),
    )


def _driving_score(result: EpisodeResult, penalties: PenaltyScheme) -> float:
    return result.driving_score_by(penalties)


def _route_completion(result: EpisodeResult, _: PenaltyScheme) -> float:
    return result.route_completion


def _infraction_score(result: EpisodeResult, penalties: PenaltyScheme) -> float:
    return result.infraction_score_by(penalties)


def _vehicle_collisions(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
    return counts_per_km(results)[InfractionKind.COLLISION_VEHICLE]


_LEAST_TTC = "minimum time to collision, vehicles / pedestrians and cyclists"
_LEAST_PET = "minimum post-encroachment time, vehicles / pedestrians and cyclists"

METRICS: tuple[Metric, ...] = (
    score_row(
        RANKED,
        "DS",
        "",
        1,
        HIGHER,
        mean_score(_driving_score),
        "Driving score, 0 to 100: the mean over episodes of route completion times infraction "
        "score. Mean ± standard deviation over repetitions.",
        episode=_driving_score,
        title="driving score (0 to 100)",
    ),
    score_row(
        "route_completion",
        "RC",
        "%",
        1,
        HIGHER,
        mean_score(_route_completion),
        "Route completion: the share of the route that was completed, in percent.",
        episode=_route_completion,
        title="route completion (%)",
    ),
    score_row(
        "infraction_score",
        "IS",
        "",
        2,
        HIGHER,
        mean_score(_infraction_score),
        "Infraction score: 1 without any infraction, less with each.",
        episode=_infraction_score,
        title="infraction score",
    ),
    score_row(
        "vehicle_collisions",
        "CV",
        "/km",
        2,
        LOWER,
        RunAggregate("total collisions / total kilometres", _vehicle_collisions),
        "Collisions with vehicles per kilometre.",
        title="collisions with vehicles per km",
    ),
    score_row(
        "normalised_score",
        "NDS",
        "",
        1,
        HIGHER,
        RunAggregate("from total infractions / total kilometres", normalised_score),
        "Normalised driving score, 0 to 100: RC times the IS that the same infractions per "
        "kilometre give over one kilometre.",
        episode=lambda result, penalties: normalised_score([result], penalties),
        title="normalised driving score (0 to 100)",
        shown=Shown.SCORE,
    ),
    measure_row(
        "ttc_vehicle",
        "time to collision, vehicles",
        "s",
        1,
        HIGHER,
        median,
        "Minimum time to collision, in steps of 0.1 s up to 5 s: the time until the bounding boxes "
        "would overlap if ego and actor kept their speeds along the paths they actually drove. "
        "Actors that follow the ego do not count.",
        title=_LEAST_TTC,
    ),
    measure_row(
        "ttc_vulnerable",
        "time to collision, pedestrians and cyclists",
        "s",
        1,
        HIGHER,
        median,
        "The same for pedestrians and cyclists.",
        title=_LEAST_TTC,
    ),
    measure_row(
        "pet_vehicle",
        "post-encroachment time, vehicles",
        "s",
        1,
        HIGHER,
        median,
        "Minimum post-encroachment time, in steps of 0.2 s up to 5 s: the smallest time shift at "
        "which the bounding boxes of the ego and of an actor that crosses its path (headings at "
        "least 60 degrees apart) would have overlapped. 0 is contact.",
        title=_LEAST_PET,
    ),
    measure_row(
        "pet_vulnerable",
        "post-encroachment time, pedestrians and cyclists",
        "s",
        1,
        HIGHER,
        median,
        "The same for pedestrians and cyclists.",
        title=_LEAST_PET,
    ),
    measure_row(
        "hard_brakes",
        "hard brakes",
        "per km",
        2,
        LOWER,
        per_km,
        "Number of times that acceleration falls below -4 m/s2; events less than 1 s apart count "
        "as one (Bench2Drive's comfort limit: -4.05 m/s2).",
        name="hard_brakes_per_km",
        title="hard brakes per km",
    ),
    measure_row(
        "hard_brake_share",
        "time braking hard",
        "share",
        2,
        LOWER,
        share_of_time,
        "Share of time with an acceleration below -4 m/s2.",
        shown=Shown.NOWHERE,
    ),
    measure_row(
        "jerk_p95",
        "jerk, 95th percentile",
        "m/s³",
        1,
        LOWER,
        mean,
        "95th percentile of absolute longitudinal jerk while moving: change of mean acceleration "
        "from one half second to the next (Bench2Drive's comfort limit: 4.13 m/s3).",
    ),
    measure_row(
        "lateral_acceleration_p95",
        "lateral acceleration, 95th percentile",
        "m/s²",
        1,
        LOWER,
        mean,
        "95th percentile of absolute speed times yaw rate over half a second, while moving "
        "(Bench2Drive's comfort limit: 4.89 m/s2).",
    ),
    measure_row(
        "relative_speed",
        "speed relative to traffic",
        "",
        2,
        NEITHER,
        mean,
        "The ego's mean speed divided by that of the vehicles within 50 m (leaderboard 2.0: on the "
        "whole map). Waiting vehicles count; parked ones do not, nor do those that follow the ego, "
        "since it limits their speed.",
    ),
    measure_row(
        "standing_share",
        "time standing",
        "share",
        2,
        NEITHER,
        share_of_time,
        "Share of time with a speed below 0.1 m/s.",
    ),
    measure_row(
        "off_lane_distance",
        "off all lanes",
        "km per km",
        3,
        LOWER,
        km_per_km,
        "Distance driven off all lanes; a part of the distance outside the lanes.",
        name="off_lane_per_km",
        title="off all lanes (km)",
        shown=Shown.INFRACTION,
    ),
    measure_row(
        "wrong_lane_distance",
        "on the wrong lane",
        "km per km",
        3,
        LOWER,
        km_per_km,
        "Distance driven on lanes of the opposite direction; the other part of it.",
        name="wrong_lane_per_km",
        title="on the wrong lane (km)",
        shown=Shown.INFRACTION,
    ),
)


def score_metrics() -> list[Metric]:
    """Return the scores, in the order of tables."""
    return [item for item in METRICS if item.shown in SCORES]


def headline_metrics() -> list[Metric]:
    """Return the scores that are columns of leaderboards."""
    return shown_metrics(Shown.HEADLINE)


def measure_metrics() -> list[Metric]:
    """Return the metrics that are not scores."""
    return [item for item in METRICS if item.shown not in SCORES]


def shown_metrics(shown: Shown) -> list[Metric]:
    """Return the metrics shown in one place."""
    return [item for item in METRICS if item.shown is shown]


def metrics_markdown(metrics: Sequence[Metric]) -> str:
    """Return a table of metrics for docs/reference/metrics.md.

    >>> print(metrics_markdown(shown_metrics(Shown.NOWHERE)))
    | name | definition | unit | better | over a run |
    |---|---|---|---|---|
    | `hard_brake_share` | Share of time with an acceleration below -4 m/s2. | share | lower | \
share of total time |
    """
    rows = [
        (
            _names(item),
            item.description,
            item.unit or "-",
            item.better or "-",
            item.aggregate.description,
        )
        for item in metrics
    ]
    head = ["| name | definition | unit | better | over a run |", "|---|---|---|---|---|"]
    return "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows)])


def _names(metric: Metric) -> str:
    """Return a metric's names: label and name of a score; column and name of a measure."""
    if metric.shown in SCORES:
        return f"{metric.label}, `{metric.name}`"
    names = dict.fromkeys((metric.column, metric.name))
    return ", ".join(f"`{name}`" for name in names if name)
