"""Comparing two agents on the same scenarios, and how small a difference can show at all.

Common random numbers: both agents drive the same routes in the same traffic.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from plant_bench.errors import InputError
from plant_bench.scoring.laws import Law
from plant_bench.scoring.results import EpisodeResult
from plant_bench.scoring.significance import sign_flip_test

INTERVAL = (2.5, 97.5)  # percentiles of the bootstrap: a 95 % interval
CONFIDENCE = 0.975  # two-sided 95 %
POWER = 0.80  # chance to find a difference that is there
LEAST_ROUTES = 5  # for an interval: fewer say too little of how routes differ


@dataclass(frozen=True)
class PairedDifference:
    """By how much the second agent's driving score is above the first's.

    Attributes:
        mean: Over all pairs.
        low: Lower end of the 95 % interval; not a number with fewer than `LEAST_ROUTES` routes.
        high: Upper end of it.
        p_value: Of `sign_flip_test`, two-sided; not a number where there is no interval.
        detectable: The smallest difference that as many pairs on as many routes would find with
            80 % power at the 95 % level; not a number where there is no interval.
        pairs: Number of scenarios both drove.
        routes: Number of routes these are on.
        unmatched_a: Episodes of the first that the second did not drive.
        unmatched_b: Episodes of the second that the first did not drive.
    """

    mean: float
    low: float
    high: float
    p_value: float
    detectable: float
    pairs: int
    routes: int
    unmatched_a: int
    unmatched_b: int


def paired_difference(
    a: Sequence[EpisodeResult],
    b: Sequence[EpisodeResult],
    *,
    law: Law = Law.LB1_0,
    seed: int = 0,
    samples: int = 10_000,
) -> PairedDifference:
    """Compare two agents on the scenarios (route, seed and density) that both drove.

    The interval is a percentile bootstrap over routes, the test one of signs over routes; in both
    the repetitions of a route stay together, since they are not independent.

    Args:
        a: Episodes of the first agent, the one to compare with.
        b: Episodes of the second agent.
        law: By which infractions become scores.
        seed: Of bootstrap and test.
        samples: Of each.

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
        gain = second[key].driving_score_by(law) - first[key].driving_score_by(law)
        differences.setdefault(first[key].route, []).append(gain)
    sums = np.array([sum(values) for values in differences.values()])
    counts = np.array([len(values) for values in differences.values()])
    low, high = _interval(sums, counts, seed, samples)
    return PairedDifference(
        mean=float(sums.sum() / counts.sum()),
        low=low,
        high=high,
        p_value=math.nan if math.isnan(low) else sign_flip_test(sums, seed=seed, samples=samples),
        detectable=_detectable_in_pairs(sums / counts),
        pairs=len(common),
        routes=len(sums),
        unmatched_a=len(first) - len(common),
        unmatched_b=len(second) - len(common),
    )


def _interval(sums: np.ndarray, counts: np.ndarray, seed: int, samples: int) -> tuple[float, float]:
    """Return the percentile bootstrap interval of the mean over routes."""
    if len(sums) < LEAST_ROUTES:
        return math.nan, math.nan
    drawn = np.random.default_rng(seed).integers(len(sums), size=(samples, len(sums)))
    means = sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1)
    low, high = np.percentile(means, INTERVAL)
    return float(low), float(high)


def _detectable_in_pairs(means: np.ndarray) -> float:
    """Return the minimal detectable difference of a paired t-test over routes."""
    if len(means) < LEAST_ROUTES:
        return math.nan
    freedom = len(means) - 1
    quantiles = _student(CONFIDENCE, freedom) + _student(POWER, freedom)
    return float(quantiles * means.std(ddof=1) / math.sqrt(len(means)))


@dataclass(frozen=True)
class Detectable:
    """The smallest difference in DS that a run's repetitions can tell apart from chance.

    Attributes:
        difference: Of mean DS, found with 80 % power at the 95 % level, two-sided.
        deviation: Standard deviation of DS over the repetitions of a route, over all routes.
        repetitions: The least number on a route.
        routes: Number of routes driven more than once.
    """

    difference: float
    deviation: float
    repetitions: int
    routes: int


def detectable_difference(
    results: Sequence[EpisodeResult], *, law: Law = Law.LB1_0
) -> Detectable | None:
    """Return the minimal detectable difference between this agent and another like it.

    Both drive the same routes, so what differs between routes drops out, and what is left is the
    variance s^2 of DS over the repetitions of a route, pooled over routes. The means of n episodes
    each then differ by chance with the standard error s sqrt(2 / n), and

        difference = (t(0.975) + t(0.80)) s sqrt(2 / n),

    t being quantiles of Student's distribution with n - routes degrees of freedom. Traffic that is
    the same for both makes chance smaller still, so this is an upper bound.

    Args:
        results: Of one agent; routes driven once are left out.
        law: By which infractions become scores.

    Returns:
        None where no route was driven twice.
    """
    routes: dict[str, list[float]] = {}
    for item in results:
        routes.setdefault(item.route, []).append(item.driving_score_by(law))
    scores = [np.array(values) for values in routes.values() if len(values) > 1]
    if not scores:
        return None
    episodes = sum(map(len, scores))
    freedom = episodes - len(scores)
    squares = sum(float(((values - values.mean()) ** 2).sum()) for values in scores)
    deviation = math.sqrt(squares / freedom)
    quantiles = _student(CONFIDENCE, freedom) + _student(POWER, freedom)
    return Detectable(
        difference=quantiles * deviation * math.sqrt(2.0 / episodes),
        deviation=deviation,
        repetitions=min(map(len, scores)),
        routes=len(scores),
    )


def _student(probability: float, freedom: int) -> float:
    """Return a quantile of Student's t, within 1 %: exact for 1 and 2, else a series.

    Abramowitz and Stegun, 26.7.5. docs/notes/libraries.md says why it is not scipy's.
    """
    if freedom == 1:
        return math.tan(math.pi * (probability - 0.5))
    if freedom == 2:
        return (2.0 * probability - 1.0) / math.sqrt(2.0 * probability * (1.0 - probability))
    z = NormalDist().inv_cdf(probability)
    return z + sum(
        (
            (z**3 + z) / 4.0 / freedom,
            (5.0 * z**5 + 16.0 * z**3 + 3.0 * z) / 96.0 / freedom**2,
            (3.0 * z**7 + 19.0 * z**5 + 17.0 * z**3 - 15.0 * z) / 384.0 / freedom**3,
        )
    )


def _by_scenario(results: Sequence[EpisodeResult]) -> dict[tuple[str, str], EpisodeResult]:
    """Return episodes by what they must share to be paired: the scenario, the town as it was."""
    found: dict[tuple[str, str], EpisodeResult] = {}
    for item in results:
        key = item.scenario, item.town_checksum
        if key in found:
            message = (
                f"{item.agent}: scenario {item.scenario} (route {item.route}, seed {item.seed}) is "
                "there twice. Give each once."
            )
            raise InputError(message)
        found[key] = item
    return found
