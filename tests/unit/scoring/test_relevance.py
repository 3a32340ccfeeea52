import math

import pytest

from plant_bench.errors import InputError
from plant_bench.scoring.relevance import relative_score


def drives(episode, *rows, **facts):
    """A row of completions for each repetition, a column for each route."""
    return [
        episode(route, repetition, completion=completion, **facts)
        for repetition, row in enumerate(rows)
        for route, completion in enumerate(row)
    ]


def test_rfds_is_the_ratio_of_mean_scores_over_repetitions(episode):
    whole = drives(episode, (1.0, 0.6), (1.0, 1.0))
    filtered = drives(episode, (0.4, 0.4), (0.5, 1.0), agent="expert-filtered@oracle")
    found = relative_score(whole, filtered)
    assert found.repetitions == pytest.approx((50.0, 75.0))
    assert found.score.mean == pytest.approx(62.5)
    assert found.score.std == pytest.approx(25.0 / math.sqrt(2.0))
    assert (found.whole.mean, found.filtered.mean) == pytest.approx((90.0, 57.5))
    assert (found.agent, found.episodes, found.unmatched) == ("expert-filtered@oracle", 4, 0)


def test_rfds_uses_only_common_scenarios(episode):
    whole = drives(episode, (1.0, 0.5, 1.0), (1.0, 1.0, 1.0))
    found = relative_score(whole, drives(episode, (0.5, 0.25)))
    assert found.score.mean == pytest.approx(50.0)
    assert math.isnan(found.score.std)
    assert (found.episodes, found.unmatched) == (2, 4)


def test_incomparable_runs_raise_input_error(episode):
    some = drives(episode, (1.0, 1.0))
    with pytest.raises(InputError, match="share no scenario"):
        relative_score(some, drives(episode, (1.0,), scenario="other"))
    with pytest.raises(InputError, match="expert scores 0"):
        relative_score(drives(episode, (0.0, 0.0)), some)
    with pytest.raises(InputError, match="longest6-sumo-v0, longest6-sumo-v2-rc2"):
        relative_score(some, drives(episode, (1.0,), protocol="longest6-sumo-v0"))
