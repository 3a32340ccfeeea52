"""Summarises the episodes of one agent's run: scores, infraction rates and measures.

DS is the mean over routes of RC x IS, not the product of the two means. A rate per kilometre is the
total count over the total kilometres: the leaderboard's sum of per-route rates is a known mistake
(carla-simulator/leaderboard#117).
"""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from pydantic import model_serializer

from plant_bench.errors import InputError
from plant_bench.scoring.comparison import Detectable, detectable_difference
from plant_bench.scoring.episode_measures import Number
from plant_bench.scoring.infractions import COLLISIONS, InfractionKind, Status
from plant_bench.scoring.metrics_table import RANKED, Metric, measure_metrics, score_metrics
from plant_bench.scoring.normalised_score import (
    LEAST_KM,
    counts_per_km,
    kilometres,
    outside_metres,
)
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.hazard import Phase
from plant_bench.world.scene import ActorKind


@dataclass(frozen=True)
class Spread:
    """Mean and sample standard deviation over repetitions; the latter is nan for a single one."""

    mean: float
    std: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Spread":
        """Return the mean and the standard deviation (n - 1) of the values."""
        std = float(np.std(values, ddof=1)) if len(values) > 1 else math.nan
        return cls(float(np.mean(values)), std)

    def text(self, digits: int) -> str:
        """Return both as text, "-" if the mean is nan.

        >>> Spread(81.356, 6.54).text(1), Spread(math.nan, math.nan).text(1)
        ('81.4 ± 6.5', '-')
        """
        if math.isnan(self.mean):
            return "-"
        mean = f"{self.mean:.{digits}f}"
        return mean if math.isnan(self.std) else f"{mean} ± {self.std:.{digits}f}"


Scores = dict[str, Spread]  # by name of `metrics_table`, in its order


@dataclass(frozen=True)
class RunMeasures:
    """The measures of a run, which are not part of any score.

    Attributes:
        episodes: Number of episodes with measures.
        values: By name of `metrics_table`; nan if there was nothing to measure.
    """

    episodes: int
    values: dict[str, float]

    def __getitem__(self, name: str) -> float:
        """Return a measure."""
        return self.values[name]

    @model_serializer
    def _flat(self) -> dict[str, int | float]:
        return {"episodes": self.episodes, **self.values}


@dataclass(frozen=True)
class Summary:
    """Results of one agent: its row of the leaderboard.

    Attributes:
        agent: Its name.
        agent_checksum: Content hash of its code and weights.
        inputs: The observation inputs that it used.
        protocol: Version of the rules it was scored under.
        penalties: The penalty scheme.
        scores: Over all towns.
        towns: Scores by town, in order of name.
        infractions_per_km: By kind, over all episodes; for OUTSIDE_LANES, kilometres outside.
        cyclists_per_km: Collisions with bicycles, which count as vehicles in every penalty scheme.
        statuses: Number of episodes by how they ended.
        hazards: Number of hazards by the last phase they reached.
        ego_share: Share of the collisions that the ego caused; nan if there were none.
        blocked: Number of blocked routes in each repetition, in order.
        km: Kilometres driven along the routes.
        episodes: Number of episodes.
        expected: Number of episodes in a complete run.
        measures: Measures that are not part of the score.
        detectable: Minimal detectable difference in DS; None if no route was repeated.
    """

    agent: str
    agent_checksum: str
    inputs: tuple[str, ...]
    protocol: str
    penalties: PenaltyScheme
    scores: Scores
    towns: dict[str, Scores]
    infractions_per_km: dict[InfractionKind, float]
    cyclists_per_km: float
    statuses: dict[Status, int]
    hazards: dict[Phase, int]
    ego_share: float
    blocked: tuple[int, ...]
    km: float
    episodes: int
    expected: int
    measures: RunMeasures
    detectable: Detectable | None

    @property
    def complete(self) -> bool:
        """True if no episode is missing."""
        return self.episodes == self.expected

    @property
    def driving_score(self) -> Spread:
        """DS, the metric that leaderboards are sorted by."""
        return self.scores[RANKED]


def summarise(
    results: Sequence[EpisodeResult],
    *,
    expected: int,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
) -> Summary:
    """Summarise the episodes of one agent.

    Args:
        results: The episodes, in any order.
        expected: Number of episodes in a complete run: routes times repetitions.
        penalties: The penalty scheme.

    Raises:
        InputError: There are none, they have several agents or protocols, or one occurs twice.
    """
    _check(results)
    first = results[0]
    collisions = [
        item for result in results for item in result.infractions if item.kind in COLLISIONS
    ]
    caused = sum(item.cause == "ego" for item in collisions)
    return Summary(
        agent=first.agent,
        agent_checksum=first.agent_checksum,
        inputs=first.inputs,
        protocol=first.protocol,
        penalties=penalties,
        scores=_scores(results, penalties),
        towns={
            town: _scores([item for item in results if item.town == town], penalties)
            for town in sorted({item.town for item in results})
        },
        infractions_per_km=_rates(results),
        cyclists_per_km=sum(_collisions_with(item, ActorKind.BICYCLE) for item in results)
        / max(kilometres(results), LEAST_KM),
        statuses={
            status: count
            for status in Status
            if (count := sum(item.status is status for item in results))
        },
        hazards=dict(Counter(item.phase for result in results for item in result.hazards)),
        ego_share=caused / len(collisions) if collisions else math.nan,
        blocked=tuple(
            sum(item.status is Status.BLOCKED for item in part) for part in _repetitions(results)
        ),
        km=kilometres(results),
        episodes=len(results),
        expected=expected,
        measures=_run_measures(results, penalties),
        detectable=detectable_difference(results, penalties=penalties),
    )


def summary_frame(
    results: Iterable[EpisodeResult], *, penalties: PenaltyScheme = PenaltyScheme.LB1_0
) -> pd.DataFrame:
    """Return one row per episode, for CSV; sorted, so that equal results give equal text."""
    ordered = sorted(results, key=lambda item: (item.agent, item.town, item.route, item.repetition))
    return pd.DataFrame([_row(result, penalties) for result in ordered])


def _row(result: EpisodeResult, penalties: PenaltyScheme) -> dict[str, object]:
    counts = Counter(item.kind for item in result.infractions)
    outside = [item.share for item in result.infractions if item.share is not None]
    events = [kind for kind in InfractionKind if kind is not InfractionKind.OUTSIDE_LANES]
    return {
        "agent": result.agent,
        "inputs": " ".join(result.inputs),
        "town": result.town,
        "route": result.route,
        "repetition": result.repetition,
        "seed": result.seed,
        "density": result.density,
        "scenario": result.scenario,
        "status": result.status.value,
        "penalties": penalties.value,
        **_columns(score_metrics(), result, penalties),
        "route_length": result.route_length,
        "distance": result.distance,
        "duration": result.duration,
        **{kind.value: counts[kind] for kind in events},
        "collisions_cyclist": _collisions_with(result, ActorKind.BICYCLE),
        "collisions_motorcyclist": _collisions_with(result, ActorKind.MOTORCYCLE),
        "outside_share": sum(outside),
        "caused_by_ego": sum(item.cause == "ego" for item in result.infractions),
        "caused_by_other": sum(item.cause == "other" for item in result.infractions),
        **_columns(measure_metrics(), result, penalties),
        "reason": result.reason,
    }


def _columns(
    metrics: Iterable[Metric], result: EpisodeResult, penalties: PenaltyScheme
) -> dict[str, Number | None]:
    """Return an episode's values by column; None (an empty cell) if it has none."""
    return {
        item.column: item.episode(result, penalties) for item in metrics if item.episode is not None
    }


def _scores(results: Sequence[EpisodeResult], penalties: PenaltyScheme) -> Scores:
    parts = _repetitions(results)
    return {
        metric.name: Spread.of([metric.aggregate.compute(part, penalties) for part in parts])
        for metric in score_metrics()
    }


def _run_measures(results: Sequence[EpisodeResult], penalties: PenaltyScheme) -> RunMeasures:
    return RunMeasures(
        episodes=sum(item.measures is not None for item in results),
        values={
            metric.name: metric.aggregate.compute(results, penalties)
            for metric in measure_metrics()
        },
    )


def _collisions_with(result: EpisodeResult, kind: ActorKind) -> int:
    return sum(item.actor_kind == kind for item in result.infractions if item.kind in COLLISIONS)


def _repetitions(results: Sequence[EpisodeResult]) -> list[list[EpisodeResult]]:
    numbers = sorted({item.repetition for item in results})
    return [[item for item in results if item.repetition == number] for number in numbers]


def _rates(results: Sequence[EpisodeResult]) -> dict[InfractionKind, float]:
    outside = sum(map(outside_metres, results)) / 1000.0 / max(kilometres(results), LEAST_KM)
    return counts_per_km(results) | {InfractionKind.OUTSIDE_LANES: outside}


def _check(results: Sequence[EpisodeResult]) -> None:
    """Check that episodes can be summarised together.

    Raises:
        InputError: There are none, they have several agents or protocols, or one occurs twice.
    """
    if not results:
        message = "No episodes to summarise. Run 'plant-bench score' first."
        raise InputError(message)
    first = results[0]
    for item in results:
        if (item.agent, item.agent_checksum) != (first.agent, first.agent_checksum):
            message = (
                f"Cannot mix episodes of two agents: {first.agent} ({first.agent_checksum[:12]}) "
                f"and {item.agent} ({item.agent_checksum[:12]}). Score one of them again."
            )
            raise InputError(message)
        if item.protocol != first.protocol:
            message = (
                f"Cannot mix episodes of two protocols: {first.protocol} and {item.protocol}. "
                "Score the older ones again."
            )
            raise InputError(message)
    counts = Counter((item.scenario, item.repetition) for item in results)
    (scenario, repetition), count = counts.most_common(1)[0]
    if count > 1:
        message = (
            f"{first.agent}: scenario {scenario}, repetition {repetition} occurs {count} times. "
            "Give each episode once."
        )
        raise InputError(message)
