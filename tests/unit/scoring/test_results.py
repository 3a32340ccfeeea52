import pytest

from plant_bench.errors import InputError
from plant_bench.scoring.infractions import PENALTIES, Infraction, InfractionKind
from plant_bench.scoring.results import RESULT_FORMAT, EpisodeResult


def test_driving_score_is_completion_times_penalties(episode):
    result = episode(completion=0.5, kinds=("collision_pedestrian", "red_light", "red_light"))
    assert result.route_completion == 50.0
    assert result.infraction_score == pytest.approx(0.5 * 0.7 * 0.7)
    assert result.driving_score == pytest.approx(50.0 * 0.5 * 0.7 * 0.7)


def test_leaderboard_1_0_penalties():
    assert [PENALTIES[InfractionKind(f"collision_{name}")] for name in
            ("pedestrian", "vehicle", "static")] == [0.50, 0.60, 0.65]  # fmt: skip
    assert PENALTIES[InfractionKind.RED_LIGHT] == 0.70


@pytest.mark.parametrize("kind", ["route_deviation", "blocked", "timeout"])
def test_termination_reasons_have_no_penalty(episode, kind):
    assert episode(kinds=(kind,)).infraction_score == 1.0


def test_every_infraction_kind_has_a_factor():
    for kind in InfractionKind:
        infraction = Infraction(kind=kind, time=0.0, x=0.0, y=0.0, progress=0.0, share=0.2)
        assert 0.0 < infraction.factor <= 1.0


def test_record_round_trip_is_exact(episode, tmp_path):
    result = episode(kinds=("collision_vehicle", "timeout"), share=0.125)
    path = tmp_path / "record.json"
    path.write_text(result.to_json(), encoding="utf-8")
    assert EpisodeResult.load(path) == result
    assert EpisodeResult.load(path).to_json() == result.to_json()


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"format": 1}'])
def test_broken_record_raises_input_error(tmp_path, text):
    path = tmp_path / "record.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="Not an episode record"):
        EpisodeResult.load(path)
    with pytest.raises(InputError, match="Not an episode record"):
        EpisodeResult.load(tmp_path / "nowhere.json")


def test_format_1_record_has_no_episode_metrics(episode):
    result = episode(kinds=("red_light",))
    old = result.as_format(1)
    assert (old.format, old.measures) == (1, None)
    assert "measures" not in old.to_json()
    assert result.as_format(RESULT_FORMAT) is result
