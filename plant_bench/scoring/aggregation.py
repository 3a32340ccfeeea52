"""Aggregates episode metrics over a run (mean, median, rates); records do not depend on it."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from plant_bench.scoring.episode_measures import Number
from plant_bench.scoring.normalised_score import LEAST_KM, kilometres
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult

EpisodeValue = Callable[[EpisodeResult, PenaltyScheme], Number | None]
RunValue = Callable[[Sequence[EpisodeResult], PenaltyScheme], float]


@dataclass(frozen=True)
class RunAggregate:
    """A way to aggregate a metric over the episodes of a run.

    Attributes:
        description: Text for the documentation.
        compute: Value over one or more episodes; nan if no episode has a value.
    """

    description: str
    compute: RunValue


def measure_of(name: str) -> EpisodeValue:
    """Return a function that reads a measure from a record."""
    return lambda result, _: None if result.measures is None else result.measures[name]


def mean_score(value: Callable[[EpisodeResult, PenaltyScheme], float]) -> RunAggregate:
    """Take the mean of a score, which every episode has."""
    return RunAggregate(
        "mean",
        lambda results, penalties: float(np.mean([value(item, penalties) for item in results])),
    )


def mean(name: str) -> RunAggregate:
    """Take the mean of a measure over the episodes that have a value."""

    def compute(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        values = [value for _, value in _measured(results, name)]
        return float(np.mean(values)) if values else math.nan

    return RunAggregate("mean", compute)


def median(name: str) -> RunAggregate:
    """Take the median of a minimum time; infinite if the median episode had no near miss."""

    def compute(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        times = [item.measures[name] for item in results if item.measures and name in item.measures]
        ordered = sorted(math.inf if time is None else time for time in times)
        if not ordered:
            return math.nan
        low, high = ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]
        return low if low == high else 0.5 * (low + high)

    return RunAggregate("median", compute)


def per_km(name: str) -> RunAggregate:
    """Divide the total number of events by the total kilometres along the routes."""

    def compute(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        return 1000.0 * _per_metre(results, name)

    return RunAggregate("total events / total kilometres", compute)


def km_per_km(name: str) -> RunAggregate:
    """Divide the total of a distance by the total distance along the routes."""

    def compute(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        return _per_metre(results, name)

    return RunAggregate("total of this distance / total kilometres", compute)


def share_of_time(name: str) -> RunAggregate:
    """Take the mean of a share of time, weighted by the episodes' durations."""

    def compute(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        measured = _measured(results, name)
        seconds = sum(item.duration for item, _ in measured)
        total = sum(value * item.duration for item, value in measured)
        return total / seconds if seconds > 0.0 else math.nan

    return RunAggregate("share of total time", compute)


def _measured(results: Sequence[EpisodeResult], name: str) -> list[tuple[EpisodeResult, Number]]:
    """Return the episodes that have a value of this measure, each with the value."""
    return [
        (item, value)
        for item in results
        if item.measures is not None and (value := item.measures[name]) is not None
    ]


def _per_metre(results: Sequence[EpisodeResult], name: str) -> float:
    measured = _measured(results, name)
    metres = 1000.0 * max(kilometres([item for item, _ in measured]), LEAST_KM)
    return sum(value for _, value in measured) / metres if measured else math.nan
