"""The table of metrics: tables, page, exports and documentation read it, and none names a metric.

A measure of an episode is a function in `scoring.episode_metrics`; its row here says what it is
called, how it is shown and how it is summed up. A figure that only a run has needs the row alone.
docs/how-to/add-a-metric.md shows how to add one. No record and no episode's key depends on
this module.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from plant_bench.scoring.infractions import InfractionKind
from plant_bench.scoring.laws import Law
from plant_bench.scoring.normalised import counts_per_km, normalised_score
from plant_bench.scoring.over_run import (
    EpisodeValue,
    OverRun,
    km_per_km,
    mean,
    mean_score,
    measure_of,
    median,
    per_km,
    share_of_time,
)
from plant_bench.scoring.results import EpisodeResult

RANKED = "driving_score"  # by which leaderboards are sorted and differences are tested


class Better(StrEnum):
    """Which values of a metric are the better ones."""

    HIGHER = "higher"
    LOWER = "lower"
    NEITHER = ""


class Shown(StrEnum):
    """Where a metric is shown. All are in `summary.json` and in the exports.

    Scores depend on the law, and are told with their deviation over repetitions and by town;
    measures are told once for all episodes.
    """

    HEADLINE = "headline"  # a score: in a run's table, and a column of every leaderboard
    SCORE = "score"  # a score: in a run's table
    MEASURE = "measure"  # below a run's table, and in the page's "Near misses and comfort"
    INFRACTION = "infraction"  # a measure, among the infractions per kilometre where it is not zero
    NOWHERE = "nowhere"  # a measure, in files alone


SCORES = (Shown.HEADLINE, Shown.SCORE)
LOWER, HIGHER, NEITHER = Better.LOWER, Better.HIGHER, Better.NEITHER


@dataclass(frozen=True)
class Metric:
    """A metric.

    Attributes:
        name: In summaries and exports.
        label: Head of its column; short.
        unit: Such as "s" or "per km"; "share" is shown in percent where there is room for it.
        digits: Shown after the point.
        better: Which values are the better ones.
        about: What it is, in a sentence or two.
        over_run: Sums up a run.
        shown: Where.
        title: Its name in full; `label` if empty. Measures of one title share a row of a run's
            table.
        column: Its name for one episode, in `summary.csv` and, for measures, in records; empty
            where only a run has it.
        episode: Its value for one episode; None where only a run has it.
    """

    name: str
    label: str
    unit: str
    digits: int
    better: Better
    about: str
    over_run: OverRun
    shown: Shown
    title: str = ""
    column: str = ""
    episode: EpisodeValue | None = None

    @property
    def full(self) -> str:
        """Its name in full."""
        return self.title or self.label


def score_row(
    name: str,
    label: str,
    unit: str,
    digits: int,
    better: Better,
    over_run: OverRun,
    about: str,
    *,
    episode: EpisodeValue | None = None,
    title: str = "",
    shown: Shown = Shown.HEADLINE,
) -> Metric:
    """Return the row of a score."""
    column = name if episode is not None else ""
    return Metric(name, label, unit, digits, better, about, over_run, shown, title, column, episode)


def measure_row(
    measure: str,
    label: str,
    unit: str,
    digits: int,
    better: Better,
    sum_up: Callable[[str], OverRun],
    about: str,
    *,
    name: str = "",
    title: str = "",
    shown: Shown = Shown.MEASURE,
) -> Metric:
    """Return the row of a measure.

    Args:
        measure: Its name in records, that of its function.
        label: As in `Metric`, as all below.
        unit: Of the run's value.
        digits: Of it.
        better: Which values are.
        sum_up: Of `scoring.over_run`: how a measure is summed up over a run.
        about: What it is.
        name: Of the run's value, if not that of the measure.
        title: Its name in full.
        shown: Where.
    """
    return Metric(
        name or measure,
        label,
        unit,
        digits,
        better,
        about,
        sum_up(measure),
        shown,
        title,
        measure,
        measure_of(measure),
    )


def _driving_score(result: EpisodeResult, law: Law) -> float:
    return result.driving_score_by(law)


def _route_completion(result: EpisodeResult, _: Law) -> float:
    return result.route_completion


def _infraction_score(result: EpisodeResult, law: Law) -> float:
    return result.infraction_score_by(law)


def _vehicle_collisions(results: Sequence[EpisodeResult], _: Law) -> float:
    return counts_per_km(results)[InfractionKind.COLLISION_VEHICLE]


_LEAST_TTC = "least time to collision, vehicles / walkers and cyclists"
_LEAST_PET = "least post-encroachment time, the same"

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
        "Route completion: the share of the route that was driven, in percent.",
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
        OverRun("all collisions over all kilometres", _vehicle_collisions),
        "Collisions with vehicles per kilometre: all of them over all kilometres.",
        title="collisions with vehicles per km",
    ),
    score_row(
        "normalised_score",
        "NDS",
        "",
        1,
        HIGHER,
        OverRun("of all infractions over all kilometres", normalised_score),
        "Normalised driving score, 0 to 100: RC times the IS that the same infractions per "
        "kilometre give over one kilometre.",
        episode=lambda result, law: normalised_score([result], law),
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
        "Least time to collision, to 0.1 s and up to 5 s: boxes at full size overlap if both keep "
        "their speed on the paths that they then took. Who follows the ego does not count.",
        title=_LEAST_TTC,
    ),
    measure_row(
        "ttc_vulnerable",
        "time to collision, walkers and cyclists",
        "s",
        1,
        HIGHER,
        median,
        "The same, with pedestrians and cyclists.",
        title=_LEAST_TTC,
    ),
    measure_row(
        "pet_vehicle",
        "post-encroachment time, vehicles",
        "s",
        1,
        HIGHER,
        median,
        "Least post-encroachment time, to 0.2 s and up to 5 s: the least shift in time at which "
        "the boxes of the ego and of an actor that crosses its path (headings 60 degrees apart or "
        "more) would have overlapped. 0 is contact.",
        title=_LEAST_PET,
    ),
    measure_row(
        "pet_vulnerable",
        "post-encroachment time, walkers and cyclists",
        "s",
        1,
        HIGHER,
        median,
        "The same, with pedestrians and cyclists.",
        title=_LEAST_PET,
    ),
    measure_row(
        "hard_brakes",
        "hard brakes",
        "per km",
        2,
        LOWER,
        per_km,
        "Events below -4 m/s2, those less than 1 s apart being one (Bench2Drive calls -4.05 "
        "uncomfortable).",
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
        "Share of time below -4 m/s2.",
        shown=Shown.NOWHERE,
    ),
    measure_row(
        "jerk_p95",
        "jerk, 95th percentile",
        "m/s³",
        1,
        LOWER,
        mean,
        "95th percentile of longitudinal jerk, either way, while moving: change of mean "
        "acceleration from one half-second to the next (Bench2Drive: 4.13 m/s3).",
    ),
    measure_row(
        "lateral_acceleration_p95",
        "lateral acceleration, 95th percentile",
        "m/s²",
        1,
        LOWER,
        mean,
        "95th percentile of speed times rate of turn over half a second, while moving "
        "(Bench2Drive: 4.89 m/s2).",
    ),
    measure_row(
        "relative_speed",
        "speed relative to traffic",
        "",
        2,
        NEITHER,
        mean,
        "The ego's mean speed over that of the vehicles within 50 m, in any direction and waiting "
        "ones too, as leaderboard 2.0 does over the whole map; not those parked, nor those that "
        "follow the ego, since it sets their speed.",
    ),
    measure_row(
        "standing_share",
        "time standing",
        "share",
        2,
        NEITHER,
        share_of_time,
        "Share of time below 0.1 m/s.",
    ),
    measure_row(
        "off_lane_distance",
        "off all lanes",
        "km per km",
        3,
        LOWER,
        km_per_km,
        "Metres driven off all lanes, a part of those outside the lanes.",
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
        "Metres driven on lanes of the other direction, the other part.",
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
    """Return the metrics that are no scores."""
    return [item for item in METRICS if item.shown not in SCORES]


def shown_metrics(shown: Shown) -> list[Metric]:
    """Return the metrics shown at one place."""
    return [item for item in METRICS if item.shown is shown]


def metrics_markdown(metrics: Sequence[Metric]) -> str:
    """Return a table of metrics for docs/reference/metrics.md.

    >>> print(metrics_markdown(shown_metrics(Shown.NOWHERE)))
    | name | is | unit | better | over a run |
    |---|---|---|---|---|
    | `hard_brake_share` | Share of time below -4 m/s2. | share | lower | share of all time |
    """
    rows = [
        (_documented(item), item.about, item.unit or "-", item.better or "-", item.over_run.words)
        for item in metrics
    ]
    head = ["| name | is | unit | better | over a run |", "|---|---|---|---|---|"]
    return "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows)])


def _documented(metric: Metric) -> str:
    """Return a metric's names: short, in records, and in summaries where that is another."""
    if metric.shown in SCORES:
        return f"{metric.label}, `{metric.name}`"
    names = dict.fromkeys((metric.column, metric.name))
    return ", ".join(f"`{name}`" for name in names if name)
