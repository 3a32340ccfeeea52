import numpy as np
import pytest

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.data.recording import Recording
from plant_bench.reports.replay.attention import attention_of, most_relevant
from plant_bench.reports.replay.overlay import progress_of
from tests.unit.reports.replay.drives import SPEED, drive, some_route

RANKER = f"""
import numpy as np
from plant_bench.agent import Input, Plan

class Ranks:
    inputs = frozenset({{Input.OBJECTS, Input.ROUTE}})
    def reset(self, route):
        assert not route.hazards
    def act(self, observation):
        ahead = np.arange(1.0, 5.0) * {SPEED} / 2.0
        return Plan(np.stack([ahead, np.full(4, 0.2 + EXTRA)], axis=1))
    def rank(self, observation):
        return np.where(observation.actors.ids == 3, 4.0, 0.5) * (observation.route.progress >= 0)
"""


def asked(tmp_path, extra, checksum=None):
    file = tmp_path / f"ranker_{extra}.py".replace(".", "_", 1)
    file = file.with_suffix(".py")
    file.write_text(RANKER.replace("EXTRA", str(extra)))
    agent = f"{file}:Ranks"
    known = agent_checksum(agent) if checksum is None else checksum
    source = drive(tmp_path, agent=agent, agent_checksum=known)
    recording, route = Recording.load(source.recording), some_route()
    return attention_of(source.result, agent, recording, route, progress_of(recording, route))


def test_planner_is_queried_at_2_hz_on_recorded_observations(tmp_path):
    attention = asked(tmp_path, 0)
    assert attention.note == ""
    assert attention.ticks.tolist() == list(range(0, 81, 10))
    assert attention.actors[0] == 3
    first = attention.shares[: attention.starts[1]]
    np.testing.assert_allclose(first, [1.0, *[0.125] * 7])


def test_other_version_with_equal_plans_is_queried(tmp_path):
    assert len(asked(tmp_path, 0, checksum="1" * 64).ticks) == 9


def test_other_version_with_different_plans_is_not_queried(tmp_path):
    attention = asked(tmp_path, 1, checksum="1" * 64)
    assert "no longer makes the recorded plans" in attention.note
    assert len(attention.ticks) == 0


@pytest.mark.parametrize("agent", ["nowhere.py:Agent", "cruise", "expert"])
def test_planner_that_cannot_be_queried_leaves_a_note(tmp_path, source, agent):
    recording, route = Recording.load(source.recording), some_route()
    place = progress_of(recording, route)
    attention = attention_of(source.result, agent, recording, route, place)
    assert attention.note
    assert len(attention.ticks) == 0


def test_order_only_ranks_show_the_first_actor():
    who, share = most_relevant(np.array([-3.0, -1.0, -2.0]), np.array([7, 8, 9]))
    assert who.tolist() == [8]
    assert share.tolist() == [1.0]
    assert len(most_relevant(np.zeros(0), np.zeros(0, int))[0]) == 0
