"""Comparing two agents on the same scenarios: common random numbers, so small differences show."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plant_bench.errors import InputError
from plant_bench.scoring.results import EpisodeResult

INTERVAL = (2.5, 97.5)  # percentiles of the bootstrap: a 95 % interval


@dataclass(frozen=True)
class PairedDifference:
    """By how much the second agent's driving score is above the first's.

    Attributes:
        mean: Over all pairs.
        low: Lower end of the 95 % interval.
        high: Upper end of it.
        pairs: Number of scenarios both drove.
        routes: Number of routes these are on.
        unmatched_a: Episodes of the first that the second did not drive.
        unmatched_b: Episodes of the second that the first did not drive.
    """

    mean: float
    low: float
    high: float
    pairs: int
    routes: int
    unmatched_a: int
    unmatched_b: int


def paired_difference(
    a: Sequence[EpisodeResult], b: Sequence[EpisodeResult], *, seed: int = 0, samples: int = 10_000
) -> PairedDifference:
    """Compare two agents on the scenarios (route, seed and density) that both drove.

    The interval is a percentile bootstrap over routes; the repetitions of a route stay together,
    since they are not independent.

    Args:
        a: Episodes of the first agent, the one to compare with.
        b: Episodes of the second agent.
        seed: Of the bootstrap.
        samples: Of the bootstrap.

    Raises:
        InputError: Their protocols differ, a scenario is there twice, or none is common.
    """
    protocols = {item.protocol for item in (*a, *b)}
    if len(protocols) > 1:
        message = (
            f"Episodes of several protocols cannot be compared: {', '.join(sorted(protocols))}."
        )
        raise InputError(message)
    first, second = _by_scenario(a), _by_scenario(b)
    common = sorted(first.keys() & second.keys())
    if not common:
        message = "The two agents share no scenario: score both on the same suite and seeds."
        raise InputError(message)
    differences: dict[str, list[float]] = {}
    for key in common:
        gain = second[key].driving_score - first[key].driving_score
        differences.setdefault(first[key].route, []).append(gain)
    sums = np.array([sum(values) for values in differences.values()])
    counts = np.array([len(values) for values in differences.values()])
    drawn = np.random.default_rng(seed).integers(len(sums), size=(samples, len(sums)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.percentile(means, INTERVAL)
    return PairedDifference(
        mean=float(sums.sum() / counts.sum()),
        low=float(low),
        high=float(high),
        pairs=len(common),
        routes=len(sums),
        unmatched_a=len(first) - len(common),
        unmatched_b=len(second) - len(common),
    )


def _by_scenario(results: Sequence[EpisodeResult]) -> dict[str, EpisodeResult]:
    found: dict[str, EpisodeResult] = {}
    for item in results:
        if item.scenario in found:
            message = (
                f"{item.agent}: scenario {item.scenario} (route {item.route}, seed {item.seed}) is "
                "there twice. Give each once."
            )
            raise InputError(message)
        found[item.scenario] = item
    return found
