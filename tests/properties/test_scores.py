from hypothesis import given
from hypothesis import strategies as st

from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.metrics import summarise
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
        protocol="longest6-sumo-v0",
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
    assert worse.infraction_score <= result.infraction_score
    assert worse.driving_score <= result.driving_score


@given(results())
def test_records_survive_their_text(result):
    assert EpisodeResult.model_validate_json(result.to_json()) == result


@given(st.lists(results(), min_size=1, max_size=6))
def test_summaries_stay_within_their_bounds(drawn):
    episodes = [item.model_copy(update={"scenario": str(i)}) for i, item in enumerate(drawn)]
    summary = summarise(episodes, expected=len(episodes))
    assert 0.0 <= summary.scores.driving_score.mean <= 100.0
    assert 0.0 <= summary.scores.infraction_score.mean <= 1.0
    assert all(rate >= 0.0 for rate in summary.infractions_per_km.values())
    assert sum(summary.statuses.values()) == len(episodes)
