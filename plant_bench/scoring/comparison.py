"""Statistical comparison of two agents: paired score difference, minimal detectable difference.

Common random numbers: both agents drive the same routes in the same traffic.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from statistics import NormalDist

import numpy as np

from plant_bench.errors import InputError
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult
from plant_bench.scoring.significance import sign_flip_test

INTERVAL = (2.5, 97.5)  # percentiles of the bootstrap: a 95 % interval
CONFIDENCE = 0.975  # two-sided 95 %
POWER = 0.80  # probability of detecting a true difference
LEAST_ROUTES = 5  # for an interval: fewer routes say too little about the variance between routes
LEVEL = 0.05  # significance level of p-values


class Verdict(StrEnum):
    """Whether the second agent is better than the first."""

    BETTER = "better"
    WORSE = "worse"
    NOT_SIGNIFICANT = "not significant"
    TOO_FEW_ROUTES = "too few routes"


@dataclass(frozen=True)
class RouteDifference:
    """The difference of two agents on one route, over the scenarios that both drove.

    Attributes:
        route: The route's id.
        first: The first agent's mean driving score.
        second: The second agent's mean driving score.
        first_episodes: The first agent's paired episodes.
        second_episodes: The second agent's, in the same order.
    """

    route: str
    first: float
    second: float
    first_episodes: tuple[EpisodeResult, ...] = field(repr=False)
    second_episodes: tuple[EpisodeResult, ...] = field(repr=False)

    @property
    def difference(self) -> float:
        """The second agent's mean driving score minus the first's."""
        return self.second - self.first


@dataclass(frozen=True)
class PairedDifference:
    """By how much the second agent's driving score is above the first's.

    Attributes:
        mean: Over all pairs.
        low: Lower end of the 95 % interval; nan with fewer than `LEAST_ROUTES` routes.
        high: Upper end of the 95 % interval; nan as above.
        p_value: Two-sided p-value of `sign_flip_test`; nan as above.
        detectable: The smallest difference that this number of pairs and routes would detect with
            80 % power at the 95 % level; nan as above.
        pairs: Number of scenarios both drove.
        routes: Number of routes of these scenarios.
        unmatched_a: Number of episodes of the first agent that the second did not drive.
        unmatched_b: Number of episodes of the second agent that the first did not drive.
        by_route: The difference on each route, the largest first.
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
    by_route: tuple[RouteDifference, ...] = field(default=(), repr=False)

    @property
    def verdict(self) -> Verdict:
        """Whether the second agent is better, by `verdict_of` with the plain p-value."""
        return verdict_of(self, self.p_value)


def verdict_of(difference: PairedDifference, p_value: float) -> Verdict:
    """Return whether the second agent is better than the first: the one rule for all outputs.

    A difference is significant if the p-value is at most `LEVEL` and the interval excludes zero.
    The interval alone does not suffice: if three of six routes differ, all to one side, a
    percentile bootstrap excludes zero although such a result is likely by chance (p = 0.25).

    Args:
        difference: The difference.
        p_value: Its p-value, corrected if it is one of several tests.
    """
    if math.isnan(difference.low):
        return Verdict.TOO_FEW_ROUTES
    if p_value <= LEVEL and difference.low > 0.0:
        return Verdict.BETTER
    if p_value <= LEVEL and difference.high < 0.0:
        return Verdict.WORSE
    return Verdict.NOT_SIGNIFICANT


def paired_difference(
    a: Sequence[EpisodeResult],
    b: Sequence[EpisodeResult],
    *,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
    seed: int = 0,
    samples: int = 10_000,
) -> PairedDifference:
    """Compare two agents on the scenarios (route, seed and density) that both drove.

    The interval is a percentile bootstrap over routes, the test a sign-flip test over routes. Both
    keep the repetitions of a route together, since they are not independent.

    Args:
        a: Episodes of the first agent, the baseline.
        b: Episodes of the second agent.
        penalties: The penalty scheme.
        seed: Random seed of the bootstrap and the test.
        samples: Number of samples of the bootstrap, and of the test.

    Raises:
        InputError: The protocols differ, a scenario occurs twice, or the agents share none.
    """
    protocols = {item.protocol for item in (*a, *b)}
    if len(protocols) > 1:
        message = f"Cannot compare episodes of different protocols: {', '.join(sorted(protocols))}."
        raise InputError(message)
    first, second = _by_scenario(a), _by_scenario(b)
    common = sorted(first.keys() & second.keys())
    if not common:
        message = "The two agents share no scenario: score both on the same suite and seeds."
        raise InputError(message)
    pairs: dict[str, list[tuple[EpisodeResult, EpisodeResult]]] = {}
    for key in common:
        pairs.setdefault(first[key].route, []).append((first[key], second[key]))
    gains = [
        [two.driving_score_by(penalties) - one.driving_score_by(penalties) for one, two in values]
        for values in pairs.values()
    ]
    sums = np.array([sum(values) for values in gains])
    counts = np.array([len(values) for values in gains])
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
        by_route=_by_route(pairs, penalties),
    )


def _by_route(
    pairs: Mapping[str, Sequence[tuple[EpisodeResult, EpisodeResult]]], penalties: PenaltyScheme
) -> tuple[RouteDifference, ...]:
    """Return the difference on each route, the largest first."""
    found = []
    for route, values in pairs.items():
        ordered = sorted(values, key=lambda pair: pair[0].repetition)
        first, second = zip(*ordered, strict=True)
        before, after = (
            math.fsum(item.driving_score_by(penalties) for item in side) / len(side)
            for side in (first, second)
        )
        found.append(RouteDifference(route, before, after, first, second))
    return tuple(sorted(found, key=lambda item: (-abs(item.difference), item.route)))


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
    """The smallest difference in DS that a run's repetitions can distinguish from chance.

    Attributes:
        difference: Of mean DS, detected with 80 % power at the 95 % level, two-sided.
        deviation: Standard deviation of DS over the repetitions of a route, pooled over routes.
        repetitions: The smallest number of repetitions of any of these routes.
        routes: Number of routes driven more than once.
    """

    difference: float
    deviation: float
    repetitions: int
    routes: int


def detectable_difference(
    results: Sequence[EpisodeResult], *, penalties: PenaltyScheme = PenaltyScheme.LB1_0
) -> Detectable | None:
    """Return the minimal detectable difference between this agent and one of the same variance.

    Both drive the same routes, so the variance between routes cancels. What remains is the
    variance s^2 of DS over the repetitions of a route, pooled over routes. The means of n episodes
    each then differ by chance with the standard error s sqrt(2 / n), and

        difference = (t(0.975) + t(0.80)) s sqrt(2 / n),

    t being quantiles of Student's distribution with n - routes degrees of freedom. This is an upper
    bound, since both agents meet the same traffic, which reduces the variance further.

    Args:
        results: Episodes of one agent; routes driven once are left out.
        penalties: The penalty scheme.

    Returns:
        None if no route was driven twice.
    """
    routes: dict[str, list[float]] = {}
    for item in results:
        routes.setdefault(item.route, []).append(item.driving_score_by(penalties))
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
    """Return episodes by the key that pairs must share: scenario and checksum of the town."""
    by_key: dict[tuple[str, str], EpisodeResult] = {}
    for item in results:
        key = item.scenario, item.town_checksum
        if key in by_key:
            message = (
                f"{item.agent}: scenario {item.scenario} (route {item.route}, seed {item.seed}) "
                "occurs twice. Give each scenario once."
            )
            raise InputError(message)
        by_key[key] = item
    return by_key
