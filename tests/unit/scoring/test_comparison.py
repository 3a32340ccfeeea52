import pytest

from plant_bench.errors import InputError
from plant_bench.scoring.comparison import paired_difference


def drives(episode, completions, repetitions=1, **facts):
    return [
        episode(route, repetition, completion=completion, **facts)
        for route, completion in enumerate(completions)
        for repetition in range(repetitions)
    ]


def test_a_constant_gain_has_no_interval(episode):
    difference = paired_difference(
        drives(episode, (0.4, 0.6, 0.8)), drives(episode, (0.5, 0.7, 0.9))
    )
    assert difference.mean == pytest.approx(10.0)
    assert difference.low == pytest.approx(10.0)
    assert difference.high == pytest.approx(10.0)
    assert (difference.pairs, difference.routes) == (3, 3)


def test_positive_where_the_second_is_better(episode):
    a, b = drives(episode, (0.5, 0.9)), drives(episode, (0.4, 0.2))
    assert paired_difference(a, b).mean == pytest.approx(-40.0)
    assert paired_difference(b, a).mean == pytest.approx(40.0)


def test_repetitions_of_a_route_stay_together(episode):
    """Three repetitions of the same routes tell no more than one of them."""
    a, b = (0.5, 0.9, 0.3, 0.8), (0.4, 0.2, 0.6, 0.7)
    once = paired_difference(drives(episode, a), drives(episode, b))
    thrice = paired_difference(drives(episode, a, 3), drives(episode, b, 3))
    assert thrice.mean == pytest.approx(once.mean)
    assert (thrice.low, thrice.high) == pytest.approx((once.low, once.high))
    assert (thrice.pairs, thrice.routes) == (12, 4)
    assert once.low < once.mean < once.high


def test_same_seed_same_interval(episode):
    a, b = drives(episode, (0.5, 0.9, 0.3)), drives(episode, (0.4, 0.2, 0.6))
    assert paired_difference(a, b, seed=1) == paired_difference(a[::-1], b, seed=1)


def test_only_common_scenarios_are_compared(episode):
    a, b = drives(episode, (0.5, 0.9, 0.3)), drives(episode, (0.4, 0.2), 2)
    difference = paired_difference(a, b)
    assert (difference.pairs, difference.unmatched_a, difference.unmatched_b) == (2, 1, 2)


def test_no_common_scenario(episode):
    with pytest.raises(InputError, match="share no scenario"):
        paired_difference([episode(0)], [episode(1)])
    with pytest.raises(InputError, match="share no scenario"):
        paired_difference([], [episode(1)])


def test_several_protocols(episode):
    with pytest.raises(InputError, match="several protocols"):
        paired_difference([episode(0)], [episode(0, protocol="longest6-sumo-v1")])


def test_a_scenario_twice(episode):
    with pytest.raises(InputError, match="twice"):
        paired_difference([episode(0), episode(0)], [episode(0)])
