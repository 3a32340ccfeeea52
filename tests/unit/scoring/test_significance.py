import math

import numpy as np
import pytest
from scipy import stats

from plant_bench.scoring.comparison import paired_difference
from plant_bench.scoring.significance import holm, sign_flip_test


def differences(routes, seed=0):
    """Draw differences like those of scores: often zero, otherwise large."""
    draw = np.random.default_rng(seed)
    return draw.choice([0.0, 0.0, 40.0, -40.0, 12.5, 64.0], size=routes)


def scipys_p(sums, samples):
    """The p-value of scipy's paired permutation test of the same sums."""
    return stats.permutation_test(
        (sums, np.zeros_like(sums)),
        lambda a, b, axis: (a - b).mean(axis=axis),
        permutation_type="samples",
        n_resamples=samples,
        vectorized=True,
        rng=np.random.default_rng(1),
    ).pvalue


@pytest.mark.parametrize("seed", range(4))
def test_p_value_for_few_routes_equals_scipy_exactly(seed):
    sums = differences(10, seed)
    assert sign_flip_test(sums) == pytest.approx(scipys_p(sums, math.inf), abs=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_p_value_for_many_routes_agrees_with_scipy(seed):
    sums = differences(36, seed)
    expected = scipys_p(sums, 10_000)
    chance = 4.0 * math.sqrt(2.0 * expected * (1.0 - expected) / 10_000) + 2e-4
    assert sign_flip_test(sums) == pytest.approx(expected, abs=chance)


def test_false_positive_rate_matches_the_significance_level():
    draw = np.random.default_rng(5)
    found = sum(
        sign_flip_test(draw.choice([0.0, 40.0, -40.0, 16.0, -16.0], size=12)) <= 0.05
        for _ in range(200)
    )
    assert 1 <= found <= 20


def test_no_difference_has_p_value_one():
    assert sign_flip_test(np.zeros(36)) == 1.0


def test_interval_equals_scipy_bootstrap(episode):
    """Routes with different numbers of episodes, drawn whole: a ratio of sums."""
    draw = np.random.default_rng(3)
    a, b = [], []
    for route in range(20):
        for repetition in range(1 + route % 3):
            completion = float(draw.uniform(0.2, 0.6))
            a.append(episode(route, repetition, completion=completion))
            b.append(
                episode(route, repetition, completion=completion + float(draw.uniform(-0.1, 0.3)))
            )
    found = paired_difference(a, b)
    gains = {item.route: [0.0, 0] for item in a}
    for first, second in zip(a, b, strict=True):
        gains[first.route][0] += second.driving_score - first.driving_score
        gains[first.route][1] += 1
    sums, counts = np.array(list(gains.values())).T
    theirs = stats.bootstrap(
        (sums, counts),
        lambda total, count, axis: total.sum(axis=axis) / count.sum(axis=axis),
        paired=True,
        method="percentile",
        n_resamples=10_000,
        rng=np.random.default_rng(2),
    ).confidence_interval
    width = theirs.high - theirs.low
    assert found.low == pytest.approx(theirs.low, abs=0.03 * width)
    assert found.high == pytest.approx(theirs.high, abs=0.03 * width)
    assert found.p_value == pytest.approx(scipys_p(sums, 10_000), abs=0.02)


def test_p_values_of_many_tests_are_corrected():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_missing_tests_are_not_counted_in_the_correction():
    corrected = holm([0.02, math.nan, 0.03])
    assert corrected[0::2] == pytest.approx([0.04, 0.04])
    assert math.isnan(corrected[1])
