"""Requests of `plant-bench rfds`."""

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.api.rfds import RelevanceRequest
from plant_bench.runner.run.score_run import ScoreRequest


def test_rfds_request_holds_the_checksum_of_the_ranker():
    episodes = ScoreRequest("expert", "longest6", None, 1, 0, "dense", hazards=True)
    request = RelevanceRequest("rule-based", ("masking", "distance"), episodes, None)
    assert request.checksum("masking") == agent_checksum("rule-based")
    assert request.checksum("distance") == ""
    assert RelevanceRequest(None, ("oracle",), episodes, None).checksum("oracle") == ""
