import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.metrics import summarise
from plant_bench.scoring.normalised_score import infraction_score_per_km, normalised_score
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult

shares = st.floats(0.0, 1.0)


@st.composite
def infractions(draw):
    kind = draw(st.sampled_from(InfractionKind))
    share = draw(shares) if kind is InfractionKind.OUTSIDE_LANES else None
    return Infraction(kind=kind, time=1.0, x=0.0, y=0.0, progress=0.0, share=share)


@st.composite
def results(draw, scenario="0"):
    return EpisodeResult(
        protocol="longest6-sumo-v2-rc2",
        agent="any",
        agent_checksum="",
        inputs=(),
        route=scenario,
        town="town01",
        scenario=scenario,
        repetition=draw(st.integers(0, 2)),
        seed=0,
        density="dense",
        town_checksum="",
        route_checksum="",
        status=draw(st.sampled_from(Status)),
        route_length=draw(st.floats(1.0, 5000.0)),
        completion=draw(shares),
        distance=draw(st.floats(0.0, 5000.0)),
        duration=1.0,
        infractions=tuple(draw(st.lists(infractions(), max_size=8))),
    )


@given(results())
def test_scores_stay_within_their_bounds(result):
    assert 0.0 <= result.driving_score <= result.route_completion <= 100.0
    assert 0.0 <= result.infraction_score <= 1.0


@given(results(), infractions())
def test_an_infraction_never_raises_the_score(result, infraction):
    worse = result.model_copy(update={"infractions": (*result.infractions, infraction)})
    for penalties in PenaltyScheme:
        assert worse.infraction_score_by(penalties) <= result.infraction_score_by(penalties)
        assert worse.driving_score_by(penalties) <= result.driving_score_by(penalties)
        assert normalised_score([worse], penalties) <= normalised_score([result], penalties)


def with_one_fault(result):
    """Return the result as the referee would give it: at most one entry for outside lanes."""
    first = [item for item in result.infractions if item.share is not None][:1]
    events = [item for item in result.infractions if item.share is None]
    return result.model_copy(update={"infractions": (*events, *first)})


@given(
    st.lists(results(), min_size=1, max_size=4), st.floats(0.0, 1.0), st.sampled_from(PenaltyScheme)
)
def test_infraction_free_driving_never_lowers_the_normalised_score(drawn, share, penalties):
    before = [with_one_fault(item) for item in drawn]
    first = before[0]
    metres = share * (1.0 - first.completion) * first.route_length
    distance = first.distance + metres
    shrunk = first.distance / distance if distance > 0.0 else 0.0
    further = first.model_copy(
        update={
            "completion": min(first.completion + metres / first.route_length, 1.0),
            "distance": distance,
            "infractions": tuple(
                item
                if item.share is None
                else item.model_copy(update={"share": item.share * shrunk})
                for item in first.infractions
            ),
        }
    )
    after = normalised_score([further, *before[1:]], penalties)
    assert after >= normalised_score(before, penalties) * (1.0 - 1e-9)


@given(results(), st.integers(2, 5), st.sampled_from(PenaltyScheme))
def test_equal_rates_give_equal_normalised_infraction_scores(result, times, penalties):
    """A multiple of the distance with the same multiple of infractions has the same score."""
    near = with_one_fault(result)
    assume(near.completion * near.route_length > 1.0)
    events = [item for item in near.infractions if item.share is None]
    shares = [item for item in near.infractions if item.share is not None]
    far = near.model_copy(
        update={
            "route_length": times * near.route_length,
            "distance": times * near.distance,
            "infractions": (*(events * times), *shares),
        }
    )
    short, long = (
        infraction_score_per_km([near], penalties),
        infraction_score_per_km([far], penalties),
    )
    assert long == pytest.approx(short, rel=1e-9, abs=1e-12)


@given(results())
def test_records_survive_a_json_round_trip(result):
    assert EpisodeResult.model_validate_json(result.to_json()) == result


@given(st.lists(results(), min_size=1, max_size=6))
def test_summaries_stay_within_their_bounds(drawn):
    episodes = [item.model_copy(update={"scenario": str(i)}) for i, item in enumerate(drawn)]
    summary = summarise(episodes, expected=len(episodes))
    assert 0.0 <= summary.scores["driving_score"].mean <= 100.0
    assert 0.0 <= summary.scores["infraction_score"].mean <= 1.0
    assert 0.0 <= summary.scores["normalised_score"].mean <= 100.0
    assert all(rate >= 0.0 for rate in summary.infractions_per_km.values())
    assert sum(summary.statuses.values()) == len(episodes)
