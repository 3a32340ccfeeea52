import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from plant_bench.errors import InputError
from plant_bench.scoring.comparison import (
    Verdict,
    detectable_difference,
    paired_difference,
    verdict_of,
)
from plant_bench.scoring.penalties import PenaltyScheme


def drives(episode, completions, repetitions=1, **facts):
    return [
        episode(route, repetition, completion=completion, **facts)
        for route, completion in enumerate(completions)
        for repetition in range(repetitions)
    ]


def test_constant_gain_has_a_zero_width_interval(episode):
    difference = paired_difference(
        drives(episode, (0.4, 0.6, 0.8, 0.1, 0.2)), drives(episode, (0.5, 0.7, 0.9, 0.2, 0.3))
    )
    assert difference.mean == pytest.approx(10.0)
    assert difference.low == pytest.approx(10.0)
    assert difference.high == pytest.approx(10.0)
    assert (difference.pairs, difference.routes) == (5, 5)
    assert difference.detectable == pytest.approx(0.0, abs=1e-9)


def test_difference_is_positive_if_the_second_run_is_better(episode):
    a, b = drives(episode, (0.5, 0.9)), drives(episode, (0.4, 0.2))
    assert paired_difference(a, b).mean == pytest.approx(-40.0)
    assert paired_difference(b, a).mean == pytest.approx(40.0)


def test_bootstrap_keeps_repetitions_of_a_route_together(episode):
    """Three equal repetitions of the routes carry no more information than one."""
    a, b = (0.5, 0.9, 0.3, 0.8, 0.5), (0.4, 0.2, 0.6, 0.7, 0.5)
    once = paired_difference(drives(episode, a), drives(episode, b))
    thrice = paired_difference(drives(episode, a, 3), drives(episode, b, 3))
    assert thrice.mean == pytest.approx(once.mean)
    assert (thrice.low, thrice.high) == pytest.approx((once.low, once.high))
    assert (thrice.pairs, thrice.routes) == (15, 5)
    assert once.low < once.mean < once.high


def test_same_seed_gives_the_same_interval(episode):
    a = drives(episode, (0.5, 0.9, 0.3, 0.1, 0.8))
    b = drives(episode, (0.4, 0.2, 0.6, 0.3, 0.8))
    assert paired_difference(a, b, seed=1) == paired_difference(a[::-1], b, seed=1)


def test_episodes_of_a_changed_town_are_not_paired(episode):
    a, b = drives(episode, (0.5, 0.9)), drives(episode, (0.4, 0.2))
    changed = b[1].model_copy(update={"town_checksum": "d" * 64})
    difference = paired_difference(a, [b[0], changed])
    assert (difference.pairs, difference.unmatched_a, difference.unmatched_b) == (1, 1, 1)


def test_too_few_routes_give_no_interval(episode):
    a, b = drives(episode, (0.5, 0.9, 0.3, 0.1), 3), drives(episode, (0.4, 0.2, 0.6, 0.3), 3)
    difference = paired_difference(a, b)
    assert difference.mean == pytest.approx(-7.5)
    assert all(map(math.isnan, (difference.low, difference.high, difference.detectable)))


def test_detectable_difference_of_pairs_has_80_percent_power(episode):
    """A t-test on as many routes finds that difference in 80 % of cases."""
    gains = (-0.2, 0.1, 0.3, 0.0, 0.2, -0.1, 0.15, 0.05)
    b = drives(episode, tuple(0.5 + gain for gain in gains))
    found = paired_difference(drives(episode, (0.5,) * len(gains)), b)
    draw = np.random.default_rng(0)
    spread = 100.0 * np.std(gains, ddof=1)
    tries = draw.normal(found.detectable, spread, (20_000, len(gains)))
    _, pvalues = stats.ttest_1samp(tries, 0.0, axis=1)
    power = np.mean(np.asarray(pvalues) < 0.05)
    assert power == pytest.approx(0.8, abs=0.03)


def test_only_common_scenarios_are_compared(episode):
    a, b = drives(episode, (0.5, 0.9, 0.3)), drives(episode, (0.4, 0.2), 2)
    difference = paired_difference(a, b)
    assert (difference.pairs, difference.unmatched_a, difference.unmatched_b) == (2, 1, 2)


def test_runs_without_a_common_scenario_are_refused(episode):
    with pytest.raises(InputError, match="share no scenario"):
        paired_difference([episode(0)], [episode(1)])
    with pytest.raises(InputError, match="share no scenario"):
        paired_difference([], [episode(1)])


def test_comparison_across_protocols_is_refused(episode):
    with pytest.raises(InputError, match="different protocols"):
        paired_difference([episode(0)], [episode(0, protocol="longest6-sumo-v0")])


def test_duplicate_scenario_is_refused(episode):
    with pytest.raises(InputError, match="twice"):
        paired_difference([episode(0), episode(0)], [episode(0)])


def test_comparison_uses_the_given_penalty_scheme(episode):
    a, b = [episode(0, kinds=("collision_vehicle",) * 2)], [episode(0)]
    assert paired_difference(a, b).mean == pytest.approx(64.0)
    assert paired_difference(a, b, penalties=PenaltyScheme.LB2_1).mean == pytest.approx(
        100.0 * (1 - 1 / 2.4)
    )


def test_detectable_difference_of_two_repetitions(episode):
    """Two routes twice, 10 and 30 DS apart: s^2 = (50 + 450) / 2, n = 4, 2 degrees of freedom."""
    results = [
        episode(route, repetition, completion=completion)
        for route, pair in enumerate(((0.5, 0.6), (0.2, 0.5)))
        for repetition, completion in enumerate(pair)
    ]
    found = detectable_difference([*results, episode(9, completion=0.1)])
    assert found is not None
    assert found.deviation == pytest.approx(math.sqrt(250.0))
    assert (found.repetitions, found.routes) == (2, 2)
    quantiles = stats.t.ppf(0.975, 2) + stats.t.ppf(0.8, 2)
    assert found.difference == pytest.approx(quantiles * math.sqrt(250.0 / 2.0), rel=0.03)


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 8, 35, 72])
def test_detectable_difference_equals_scipy_for_few_repetitions(episode, freedom):
    """One route, driven once more than there are degrees of freedom, 10 and 30 DS in turn."""
    count = freedom + 1
    scores = [0.1 + 0.2 * (place % 2) for place in range(count)]
    found = detectable_difference([episode(0, n, completion=s) for n, s in enumerate(scores)])
    assert found is not None
    quantiles = stats.t.ppf(0.975, freedom) + stats.t.ppf(0.8, freedom)
    expected = quantiles * float(np.std(scores, ddof=1)) * 100.0 * math.sqrt(2.0 / count)
    assert found.difference == pytest.approx(expected, rel=0.01)


def test_constant_scores_make_any_difference_detectable(episode):
    found = detectable_difference(drives(episode, (0.5, 0.9), 3))
    assert found is not None
    assert found.difference == 0.0


def test_one_repetition_has_no_detectable_difference(episode):
    assert detectable_difference(drives(episode, (0.5, 0.9))) is None


def test_detectable_difference_is_found_with_80_percent_power():
    generator = np.random.default_rng(0)
    routes, repetitions, deviation = 12, 3, 10.0
    quantiles = stats.t.ppf(0.975, 24) + stats.t.ppf(0.8, 24)
    gain = quantiles * deviation * math.sqrt(2.0 / (routes * repetitions))
    found = 0
    for _ in range(1000):
        a, b = generator.normal(0.0, deviation, (2, routes, repetitions))
        difference = b.mean() + gain - a.mean()
        pooled = 0.5 * (a.var(axis=1, ddof=1).mean() + b.var(axis=1, ddof=1).mean())
        error = math.sqrt(2.0 * pooled / (routes * repetitions))
        found += difference > stats.t.ppf(0.975, 48) * error
    assert 0.77 < found / 1000 < 0.87


def test_interval_above_zero_with_three_differing_routes_is_not_significant(episode):
    """A percentile bootstrap excludes zero by construction; the test over routes does not."""
    a = drives(episode, (0.5, 0.5, 0.5, 0.5, 0.5, 0.5))
    b = drives(episode, (0.6, 0.9, 0.7, 0.5, 0.5, 0.5))
    better, worse = paired_difference(a, b), paired_difference(b, a)

    assert better.low > 0.0
    assert better.p_value == pytest.approx(0.25)
    assert (better.verdict, worse.verdict) == (Verdict.NOT_SIGNIFICANT, Verdict.NOT_SIGNIFICANT)


def test_verdict_needs_a_small_p_value_and_an_interval_without_zero(episode):
    a = drives(episode, (0.5, 0.4, 0.3, 0.5, 0.5, 0.6))
    b = drives(episode, (0.6, 0.5, 0.4, 0.7, 0.6, 0.7))
    better, worse = paired_difference(a, b), paired_difference(b, a)

    assert (better.verdict, worse.verdict) == (Verdict.BETTER, Verdict.WORSE)
    assert verdict_of(better, 0.051) is Verdict.NOT_SIGNIFICANT
    assert verdict_of(replace(better, low=-0.1), 0.01) is Verdict.NOT_SIGNIFICANT
    assert paired_difference(a[:4], b[:4]).verdict is Verdict.TOO_FEW_ROUTES


def test_routes_are_listed_by_the_size_of_their_difference(episode):
    a = drives(episode, (0.5, 0.9, 0.3), repetitions=2)
    b = drives(episode, (0.4, 0.9, 0.8), repetitions=2)

    first, second, third = paired_difference(a, b).by_route

    assert [first.difference, second.difference, third.difference] == pytest.approx([50, -10, 0])
    assert (first.first, first.second) == pytest.approx((30.0, 80.0))
    assert first.route == a[4].route
    assert first.first_episodes == tuple(a[4:])
    assert first.second_episodes == tuple(b[4:])
