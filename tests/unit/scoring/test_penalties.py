import pytest

from plant_bench.errors import InputError
from plant_bench.scoring.infractions import COEFFICIENTS, InfractionKind
from plant_bench.scoring.penalties import PenaltyScheme, infraction_score, penalty_scheme_of


@pytest.mark.parametrize(
    ("hits", "multiplicative", "additive"),
    [(1, 0.600, 0.588), (2, 0.360, 0.417), (5, 0.078, 0.222)],
)
def test_penalty_of_vehicle_collisions(episode, hits, multiplicative, additive):
    """Figures from the published comparison of the two leaderboards' penalties."""
    result = episode(kinds=("collision_vehicle",) * hits)
    assert result.infraction_score_by(PenaltyScheme.LB1_0) == pytest.approx(
        multiplicative, abs=5e-4
    )
    assert result.infraction_score_by(PenaltyScheme.LB2_1) == pytest.approx(additive, abs=5e-4)
    assert result.driving_score_by(PenaltyScheme.LB2_1) == pytest.approx(100.0 * additive, abs=5e-2)


def test_penalty_of_one_infraction_of_each_kind(episode):
    kinds = ("collision_pedestrian", "collision_vehicle", "collision_static", "red_light")
    result = episode(kinds=kinds, share=0.2)
    assert result.infraction_score_by(PenaltyScheme.LB1_0) == pytest.approx(
        0.5 * 0.6 * 0.65 * 0.7 * 0.8
    )
    assert result.infraction_score_by(PenaltyScheme.LB2_1) == pytest.approx(
        0.8 / (1 + 1 + 0.7 + 0.6 + 0.4)
    )


def test_default_penalty_scheme_is_lb1_0(episode):
    result = episode(completion=0.5, kinds=("red_light",))
    assert result.infraction_score == result.infraction_score_by(PenaltyScheme.LB1_0) == 0.7
    assert result.driving_score == result.driving_score_by(PenaltyScheme.LB1_0)


@pytest.mark.parametrize("penalties", PenaltyScheme)
@pytest.mark.parametrize("kind", ["route_deviation", "blocked", "timeout"])
def test_termination_reasons_have_no_penalty(episode, kind, penalties):
    assert episode(kinds=(kind,)).infraction_score_by(penalties) == 1.0


def test_every_infraction_kind_has_a_coefficient():
    assert set(COEFFICIENTS) == set(InfractionKind) - {InfractionKind.OUTSIDE_LANES}


@pytest.mark.parametrize("penalties", PenaltyScheme)
def test_fractional_rates_are_penalised(penalties):
    half = infraction_score({InfractionKind.RED_LIGHT: 0.5}, 1.0, penalties)
    assert infraction_score({InfractionKind.RED_LIGHT: 1.0}, 1.0, penalties) < half < 1.0


def test_penalty_schemes_are_found_by_name():
    assert [penalty_scheme_of(penalties.value) for penalties in PenaltyScheme] == list(
        PenaltyScheme
    )
    with pytest.raises(
        InputError, match=r"Unknown penalty scheme 'lb2.0': expected lb1.0 or lb2.1"
    ):
        penalty_scheme_of("lb2.0")
