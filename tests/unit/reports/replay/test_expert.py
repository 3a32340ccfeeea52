"""Whom the expert would brake for: in blue, at its times, and only as far as it is known."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import NOBODY
from plant_bench.reports.replay.movie import SAVERS, MovieRequest
from plant_bench.reports.replay.replay_episode import load_episode, replay_script
from plant_bench.reports.replay.replay_page import palette
from plant_bench.reports.replay.replay_site import replay_path, write_replays
from plant_bench.reports.replay.snapshots import snapshot_at
from plant_bench.runner.review.expert_braking import ExpertView
from tests.unit.reports.replay.drives import drive
from tests.unit.reports.replay.test_movie import pixels, quiet
from tests.unit.reports.replay.unpacking import facts_of, unpack

DIFFERS = "from 1.0 s on it is another episode"


def third_from_half_a_second(recording, result, route):
    """The expert brakes for actor 3 from 0.5 s on, until the scenes differ at 1.0 s."""
    assert len(recording) == 81
    assert result.route == route.id
    return ExpertView(np.array([0, 10]), np.array([NOBODY, 3]), DIFFERS)


@pytest.fixture
def asked(tmp_path):
    return replace(drive(tmp_path, plans=False), ask_expert=third_from_half_a_second)


def test_the_data_hold_the_experts_actor_at_its_times(asked):
    facts = facts_of(replay_script(load_episode(asked)))
    columns = unpack(facts["columns"], facts["data"])
    assert columns["expert.tick"].tolist() == [0, 10]
    assert (columns["expert.actor"] - 1).tolist() == [NOBODY, 3]
    assert facts["expertNote"] == DIFFERS
    assert not facts["expertDrove"]


def test_a_moment_tells_the_experts_actor_from_the_planners_own(asked):
    episode = load_episode(asked)
    told = {time: snapshot_at(episode, time).expert_brakes_for for time in (0.4, 0.5, 1.5, 3.0)}
    assert told == {0.4: NOBODY, 0.5: 3, 1.5: 3, 3.0: NOBODY}, "nothing is shown where it ends"
    assert snapshot_at(episode, 3.0).brakes_for == 1


def test_nobody_is_asked_unless_that_is_wanted(source):
    episode = load_episode(source)
    assert episode.expert is None
    names = {name for name, *_ in facts_of(replay_script(episode))["columns"]}
    assert not {"expert.tick", "expert.actor"} & names


def test_where_the_expert_drove_its_own_reasons_are_shown_as_the_experts(tmp_path):
    moment = snapshot_at(load_episode(drive(tmp_path, agent="expert", plans=False)), 1.0)
    assert (moment.expert_brakes_for, moment.brakes_for, moment.reason) == (1, NOBODY, "leader")


def test_only_the_experts_box_is_blue(tmp_path, asked):
    blue = np.array([int(palette()["light"]["expert"][at : at + 2], 16) for at in (1, 3, 5)])
    counts = []
    for time in (0.5, 3.0):
        path = tmp_path / "a.png"
        SAVERS["png"]([load_episode(asked)], MovieRequest(time=time), path, quiet)
        counts.append((np.abs(pixels(path) - blue).max(axis=-1) < 12).sum())
    assert counts[0] > 100
    assert counts[1] == 0, "the planner's own reason has another mark"


def test_a_replay_is_made_again_when_the_expert_is_wanted(tmp_path, asked):
    plain = replace(asked, ask_expert=None)
    for source, told in ((plain, False), (asked, True)):
        write_replays(tmp_path, [source], workers=1, progress=lambda *_: None)
        assert ("expert.tick" in replay_path(tmp_path, asked.id).read_text()) is told
