"""The actor that the expert would brake for: in blue, over time, and only while known."""

from dataclasses import replace

import numpy as np
import pytest

from plant_bench.agent import NO_ACTOR
from plant_bench.reports.replay.movie import SAVERS, MovieRequest
from plant_bench.reports.replay.replay_episode import load_episode, replay_script
from plant_bench.reports.replay.replay_page import palette
from plant_bench.reports.replay.replay_site import replay_path, write_replays
from plant_bench.reports.replay.snapshots import snapshot_at
from plant_bench.runner.review.expert_braking import ExpertView
from tests.unit.reports.replay.drives import drive
from tests.unit.reports.replay.test_movie import pixels, quiet
from tests.unit.reports.replay.unpacking import facts_of, unpack

DIFFERS = "The simulation differs from the recording from 1.0 s on"


def third_from_half_a_second(recording, result, route):
    """The expert brakes for actor 3 from 0.5 s on, until the scenes differ at 1.0 s."""
    assert len(recording) == 81
    assert result.route == route.id
    return ExpertView(np.array([0, 10]), np.array([NO_ACTOR, 3]), DIFFERS)


@pytest.fixture
def asked(tmp_path):
    return replace(drive(tmp_path, plans=False), ask_expert=third_from_half_a_second)


def test_replay_data_holds_the_actor_of_the_expert_over_time(asked):
    facts = facts_of(replay_script(load_episode(asked)))
    columns = unpack(facts["columns"], facts["data"])
    assert columns["expert.tick"].tolist() == [0, 10]
    assert (columns["expert.actor"] - 1).tolist() == [NO_ACTOR, 3]
    assert facts["expertNote"] == DIFFERS
    assert not facts["expertDrove"]


def test_frame_distinguishes_the_actors_of_expert_and_planner(asked):
    episode = load_episode(asked)
    told = {time: snapshot_at(episode, time).expert_brakes_for for time in (0.4, 0.5, 1.5, 3.0)}
    assert told == {0.4: NO_ACTOR, 0.5: 3, 1.5: 3, 3.0: NO_ACTOR}, "nothing is shown where it ends"
    assert snapshot_at(episode, 3.0).brakes_for == 1


def test_expert_is_queried_only_on_request(source):
    episode = load_episode(source)
    assert episode.expert is None
    names = {name for name, *_ in facts_of(replay_script(episode))["columns"]}
    assert not {"expert.tick", "expert.actor"} & names


def test_reasons_of_an_expert_run_are_shown_as_those_of_the_expert(tmp_path):
    moment = snapshot_at(load_episode(drive(tmp_path, agent="expert", plans=False)), 1.0)
    assert (moment.expert_brakes_for, moment.brakes_for, moment.reason) == (1, NO_ACTOR, "leader")


def test_only_the_box_of_the_expert_is_blue(tmp_path, asked):
    blue = np.array([int(palette()["light"]["expert"][at : at + 2], 16) for at in (1, 3, 5)])
    counts = []
    for time in (0.5, 3.0):
        path = tmp_path / "a.png"
        SAVERS["png"]([load_episode(asked)], MovieRequest(time=time), path, quiet)
        counts.append((np.abs(pixels(path) - blue).max(axis=-1) < 12).sum())
    assert counts[0] > 100
    assert counts[1] == 0, "the planner's own reason has another mark"


def test_replay_is_rebuilt_when_the_expert_is_requested(tmp_path, asked):
    plain = replace(asked, ask_expert=None)
    for source, told in ((plain, False), (asked, True)):
        write_replays(tmp_path, [source], workers=1, progress=lambda *_: None)
        assert ("expert.tick" in replay_path(tmp_path, asked.id).read_text()) is told
