"""A recorded episode simulated again: equal scenes, and the responses of `collect --driver`."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.runner.collect.dagger import DaggerOverride
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.runner.review.expert_queries import ask_expert
from plant_bench.runner.review.postmortem import review_episode
from plant_bench.runner.review.resimulation import simulate_again
from plant_bench.runner.review.review_frames import Window
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route

pytestmark = pytest.mark.sumo
DRIVER = "idm"


@pytest.fixture(scope="module")
def route(beginning: Callable[[int], Route]) -> Route:
    return beginning(120)


@pytest.fixture(scope="module")
def driven(route: Route, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, EpisodeResult]:
    file = tmp_path_factory.mktemp("driven") / "episode.parquet"
    return file, run_episode(job(DRIVER, route), recording=file).result


def job(agent: str, route: Route) -> Job:
    return Job(agent, agent_checksum(agent), route, 0, 5, "dense")


def test_resimulation_reproduces_every_scene_exactly(
    driven: tuple[Path, EpisodeResult], route: Route
) -> None:
    file, result = driven
    recording = Recording.load(file)

    again = list(simulate_again(recording, result, route))

    assert len(again) == len(recording) > 100
    assert {tick.difference for tick in again} == {""}
    assert max(len(tick.recorded.actors) for tick in again) > 5


def changed_at(recording: Recording, tick: int, folder: Path) -> Recording:
    """Return a recording with a changed control at one tick."""
    recorder = Recorder(folder / "changed.parquet", recording.metadata)
    for row, (scene, action) in enumerate(zip(recording, recording.actions, strict=True)):
        recorder.add(scene, replace(action, acceleration=-1.0) if row == tick else action)  # pyright: ignore
    recorder.close()
    return Recording.load(folder / "changed.parquet")


def test_resimulation_detects_a_changed_control_at_the_next_tick(
    driven: tuple[Path, EpisodeResult], route: Route, tmp_path: Path
) -> None:
    file, result = driven
    recording = Recording.load(file)
    changed = changed_at(recording, 30, tmp_path)

    found = [tick.row for tick in simulate_again(changed, result, route) if tick.difference]

    assert found[0] == 31


def test_expert_responds_as_it_does_during_collection(
    driven: tuple[Path, EpisodeResult], route: Route, tmp_path: Path
) -> None:
    collected = tmp_path / "collected.parquet"
    run_episode(
        job("expert", route), recording=collected, override=DaggerOverride(DRIVER, route, 0)
    )
    told = Recording.load(collected)
    file, result = driven
    recording = Recording.load(file)
    last = len(recording) - 1

    looked = review_episode(recording, result, route, [Window(0, last, last)])

    same = np.all(told.egos[: last + 1] == recording.egos[: len(told)], axis=1)
    assert same.all()  # the expert did not take over
    answers = {row: action for row, action in enumerate(told.actions) if action is not None}
    asked = {
        tick: moment.expert
        for tick, moment in looked.moments.items()
        if moment.expert is not None and moment.expert.tick == tick
    }
    assert sorted(asked) == sorted(answers)
    for tick, answer in asked.items():
        assert answer.action == answers[tick]
        assert answer.reason == told.reasons[tick]
    assert len({answer.reason for answer in asked.values()}) > 1
    assert looked.planner_note == ""
    ranked = looked.moments[last].planner
    assert ranked is not None
    assert math.isfinite(ranked.control.acceleration)


def test_expert_is_queried_at_2_hz_until_the_scenes_differ(
    driven: tuple[Path, EpisodeResult], route: Route, tmp_path: Path
) -> None:
    file, result = driven
    recording = Recording.load(file)

    whole = ask_expert(recording, result, route)
    again = ask_expert(changed_at(recording, 30, tmp_path), result, route)

    moving = recording.egos[whole.ticks, 3] >= 0.5
    assert set(range(0, len(recording) - 1, 10)) <= set(whole.ticks.tolist())
    assert not (whole.ticks[moving] % 10).any()
    assert whole.note == ""
    looked = review_episode(recording, result, route, [Window(0, len(recording) - 2, 0)])
    answers = [looked.moments[tick].expert for tick in whole.ticks.tolist()]
    told = [item and item.reason and item.reason.actor for item in answers]
    assert whole.actors.tolist() == told
    assert len(set(told)) > 1
    assert again.ticks.max() <= 30
    assert again.note == "The simulation differs from the recording from 1.6 s on: the ego."


def test_responses_of_a_changed_planner_are_not_used(
    driven: tuple[Path, EpisodeResult], route: Route
) -> None:
    file, result = driven
    other = result.model_copy(update={"agent": "cruise"})

    looked = review_episode(Recording.load(file), other, route, [Window(0, 40, 0)])

    assert "its action differs from the recorded one" in looked.planner_note
    assert looked.moments[40].planner is None
    assert looked.moments[40].expert is not None


def test_changed_route_is_refused(
    beginning: Callable[[int], Route], driven: tuple[Path, EpisodeResult], route: Route
) -> None:
    file, result = driven

    with pytest.raises(InputError, match="has changed since"):
        next(simulate_again(Recording.load(file), result, beginning(90)))
