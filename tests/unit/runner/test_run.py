import pytest

from plant_bench.runner.run.score_run import ScoreRequest


@pytest.mark.parametrize(
    ("suite", "name"),
    [
        ("longest6", "cruise-longest6"),
        ("maps/mytown/routes", "cruise-mytown"),
        ("maps/mytown/routes/mytown.json", "cruise-mytown"),
    ],
)
def test_a_run_is_named_after_its_agent_and_suite(suite: str, name: str) -> None:
    assert ScoreRequest("cruise", suite).run_name == name
