"""How metrics are summed up over the episodes of a run; no record depends on this module."""

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
    """A way to sum up episodes.

    Attributes:
        words: What it is, for the documentation.
        of: Sums up at least one episode; nan where there is nothing to sum up.
    """

    words: str
    of: RunValue


def measure_of(name: str) -> EpisodeValue:
    """Return what reads a measure from a record."""
    return lambda result, _: None if result.measures is None else result.measures[name]


def mean_score(value: Callable[[EpisodeResult, PenaltyScheme], float]) -> RunAggregate:
    """Take the mean of a score, which every episode has."""
    return RunAggregate(
        "mean",
        lambda results, penalties: float(np.mean([value(item, penalties) for item in results])),
    )


def mean(name: str) -> RunAggregate:
    """Take the mean of a measure; episodes in which there was nothing to measure do not count."""

    def of(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        values = [value for _, value in _told(results, name)]
        return float(np.mean(values)) if values else math.nan

    return RunAggregate("mean", of)


def median(name: str) -> RunAggregate:
    """Take the median of a least time: infinite where the middle episode had no near miss."""

    def of(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        found = [item.measures[name] for item in results if item.measures and name in item.measures]
        ordered = sorted(math.inf if value is None else value for value in found)
        if not ordered:
            return math.nan
        low, high = ordered[(len(ordered) - 1) // 2], ordered[len(ordered) // 2]
        return low if low == high else 0.5 * (low + high)

    return RunAggregate("median", of)


def per_km(name: str) -> RunAggregate:
    """Divide all events by all kilometres along the routes."""

    def of(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        return 1000.0 * _per_metre(results, name)

    return RunAggregate("all events over all kilometres", of)


def km_per_km(name: str) -> RunAggregate:
    """Divide all metres by all metres along the routes."""

    def of(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        return _per_metre(results, name)

    return RunAggregate("all kilometres of it over all kilometres", of)


def share_of_time(name: str) -> RunAggregate:
    """Take the share of all time, of shares of each episode's time."""

    def of(results: Sequence[EpisodeResult], _: PenaltyScheme) -> float:
        told = _told(results, name)
        seconds = sum(item.duration for item, _ in told)
        total = sum(value * item.duration for item, value in told)
        return total / seconds if seconds > 0.0 else math.nan

    return RunAggregate("share of all time", of)


def _told(results: Sequence[EpisodeResult], name: str) -> list[tuple[EpisodeResult, Number]]:
    """Return the episodes in which there was something to measure, with what was measured."""
    return [
        (item, value)
        for item in results
        if item.measures is not None and (value := item.measures[name]) is not None
    ]


def _per_metre(results: Sequence[EpisodeResult], name: str) -> float:
    told = _told(results, name)
    metres = 1000.0 * max(kilometres([item for item, _ in told]), LEAST_KM)
    return sum(value for _, value in told) / metres if told else math.nan
