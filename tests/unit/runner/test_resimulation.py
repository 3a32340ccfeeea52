"""Scenes are equal or the difference is named; without facts the expert is not queried."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.agent import Control, Privileged
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.runner.episode.loop import Episode
from plant_bench.runner.review import postmortem
from plant_bench.runner.review.resimulation import (
    Tick,
    scenario_of,
    scene_difference,
    simulate_again,
)
from plant_bench.runner.review.review_frames import Window
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, Scenario
from plant_bench.world.scene import Actors, Light, Scene
from tests.builders import make_actors, make_ego, make_scene


def scene(tick: int = 0, **changes: Any) -> Scene:
    actors = make_actors([(20.0, 0.0), (30.0, 3.0)], extents=(2.0, 2.0), ids=(1, 2))
    ego = make_ego(2.0, x=0.1 * tick)
    return replace(make_scene(tick, ego=ego, actors=actors, lights=[Light.UNKNOWN]), **changes)


def moved(by: float) -> Actors:
    actors = scene().actors
    return replace(actors, poses=actors.poses + np.float32(by))


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (scene(), ""),
        (scene(3), "tick 0, simulated 3"),
        (scene(ego=make_ego(2.0, x=1e-12)), "the ego"),
        (scene(actors=scene().actors.only(np.array([0]))), "the set of actors (2)"),
        (scene(actors=moved(1e-6)), "the actors' poses"),
        (scene(lights=np.ones(1, np.uint8)), "the traffic lights"),
    ],
)
def test_the_first_difference_is_named(other: Scene, words: str):
    assert scene_difference(scene(), other) == words


def result(route: Route, **changes: Any) -> EpisodeResult:
    known: dict[str, Any] = {
        "protocol": "longest6-sumo-v2-rc2", "agent": "cruise", "agent_checksum": "c0ffee",
        "inputs": (), "route": route.id, "town": route.town,
        "scenario": Scenario(route, 7, "dense", hazards=True).key, "repetition": 0, "seed": 7,
        "density": "dense", "town_checksum": "aa", "route_checksum": route.checksum,
        "status": Status.COMPLETED, "route_length": route.length, "completion": 1.0,
        "distance": 40.0, "duration": 2.0,
    }  # fmt: skip
    return EpisodeResult(**(known | changes))


def test_scenario_is_recovered_with_and_without_hazards(route):
    one = route("a")
    bare = Scenario(one, 7, "dense", hazards=False)

    assert scenario_of(result(one), one).hazards
    assert scenario_of(result(one, scenario=bare.key), one) == bare
    with pytest.raises(InputError, match="has changed since"):
        scenario_of(result(one), route("a", 50))


def recorded(folder: Path, count: int = 12, every: int = 1) -> Recording:
    recorder = Recorder(folder / "a.parquet", {}, every=every)
    for tick in range(count):
        action = Control(2.5, 0.0) if tick < count - 1 else None
        recorder.add(scene(tick), action)
    recorder.close()
    return Recording.load(folder / "a.parquet")


def test_thinned_recording_cannot_be_resimulated(route, tmp_path: Path):
    thinned = recorded(tmp_path, every=5)

    with pytest.raises(InputError, match="thinned"):
        next(simulate_again(thinned, result(route("a")), route("a")))


def facts() -> Privileged:
    zeros = np.zeros(2)
    paths = np.zeros((2, 121, 3))
    paths[..., 0] = np.arange(121.0) + np.array([[20.0], [30.0]])
    return Privileged(paths, zeros, zeros + 10.0, zeros + np.inf, zeros)


def looked(monkeypatch, folder: Path, line: Route, differs_at: int | None, agent: str):
    """Review a recording with a scripted simulation."""
    recording = recorded(folder)

    def again(recording: Recording, *_: Any, until: int):
        for row in range(until + 1):
            differs = differs_at is not None and row >= differs_at
            difference = "the ego" if differs else ""
            decided = row < len(recording) - 1
            episode = object.__new__(Episode)  # it is not used here
            yield Tick(row, recording[row], difference, Control(2.5, 0.0), decided, facts, episode)

    monkeypatch.setattr(postmortem, "simulate_again", again)
    told = result(line, agent=agent)
    return postmortem.review_episode(recording, told, line, [Window(2, 11, 2)])


def test_expert_is_not_queried_after_the_first_difference(monkeypatch, route, tmp_path: Path):
    found = looked(monkeypatch, tmp_path, route("a"), 6, "cruise")

    assert (found.differs_at, found.difference) == (6, "the ego")
    assert found.moments[5].expert is not None
    assert all(found.moments[tick].expert is None for tick in range(6, 12))
    assert "differs from the recording: the ego" in found.expert_note


def test_planner_with_different_responses_is_no_longer_queried(monkeypatch, route, tmp_path: Path):
    found = looked(monkeypatch, tmp_path, route("a"), None, "idm")

    assert "its action differs from the recorded one" in found.planner_note
    assert found.moments[11].planner is None
    assert found.differs_at is None


def test_missing_agent_is_reported(monkeypatch, route, tmp_path: Path):
    found = looked(monkeypatch, tmp_path, route("a"), None, "gone.py:Agent")

    assert "There is no file" in found.planner_note
    assert found.moments[11].expert is not None
