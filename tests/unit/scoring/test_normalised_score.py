import pytest

from plant_bench.scoring.normalised_score import infraction_score_per_km, normalised_score
from plant_bench.scoring.penalties import PenaltyScheme

HIT = ("collision_vehicle",)


def test_normalised_score_of_hand_computed_cases(episode):
    """Two hits on 4 km: half a hit a kilometre."""
    results = [episode(0, length=1500.0, kinds=HIT), episode(1, length=2500.0, kinds=HIT)]
    assert normalised_score(results) == pytest.approx(100.0 * 0.6**0.5)
    assert normalised_score(results, PenaltyScheme.LB2_1) == pytest.approx(
        100.0 / (1.0 + 0.7 * 0.5)
    )


def test_normalised_score_of_one_kilometre_is_the_driving_score(episode):
    result = episode(length=1000.0, kinds=("red_light", *HIT), share=0.1)
    for penalties in PenaltyScheme:
        assert normalised_score([result], penalties) == pytest.approx(
            result.driving_score_by(penalties)
        )


def test_driving_farther_at_the_same_infraction_rate_scores_higher(episode):
    """DS is lower for it, which is why this score exists."""
    short = episode(length=4000.0, completion=0.25, kinds=HIT)
    far = episode(length=4000.0, completion=1.0, kinds=HIT * 4)
    assert far.driving_score < short.driving_score
    assert infraction_score_per_km([far]) == pytest.approx(infraction_score_per_km([short]))
    assert normalised_score([far]) == pytest.approx(4.0 * normalised_score([short]))


def test_outside_lanes_share_is_of_the_total_distance(episode):
    results = [episode(0, length=1000.0, share=0.4), episode(1, length=3000.0)]
    assert normalised_score(results) == pytest.approx(100.0 * (1.0 - 0.1))


def test_normalised_score_without_any_distance_is_zero(episode):
    assert normalised_score([episode(completion=0.0, kinds=HIT)]) == 0.0
    assert normalised_score([episode(completion=0.0)]) == 0.0
