"""`import plant_bench` with SUMO: one planner in every form, an episode tick by tick."""

import json
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plant_bench as pb
from plant_bench.agent_check import same_action
from plant_bench.agents import cruise
from plant_bench.data.recording import Recording
from plant_bench.runner.episode.jobs import repetition_seed
from plant_bench.runner.run.episode_queue import EpisodeEnded
from plant_bench.world.route import ROUTE_FORMAT
from tests.shortened import first_metres

pytestmark = pytest.mark.sumo
EXAMPLE = Path(__file__).parents[2] / "examples" / "my_agent.py"
ROUTE = "short-0"
OF_THE_PLANNER = {"agent", "agent_checksum"}


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a suite of one short route."""
    payload = {"format": ROUTE_FORMAT, "routes": [first_metres(40, ROUTE).to_payload()]}
    (tmp_path / "short.json").write_text(json.dumps(payload))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def score(planner: Any, **more: Any) -> pb.Run:
    settings = {"suite": "short.json", "repetitions": 1, "workers": 1, "density": "light"}
    return pb.score(planner, **(settings | more))


def driven(run: pb.Run) -> list[dict[str, Any]]:
    return [result.model_dump(exclude=OF_THE_PLANNER) for result in run.results]


def local_planner(acceleration: float) -> type:
    """Return a class as defined in a notebook: no other process can import it."""

    class Local:
        inputs = frozenset({pb.Input.ROUTE})

        def reset(self, route: pb.Route | None) -> None:
            self.ticks = 0

        def act(self, observation: pb.Observation) -> pb.Control:
            self.ticks += 1
            return pb.Control(acceleration if self.ticks < 100 else 0.5, 0.0)

    return Local


def test_name_file_class_and_object_score_the_same() -> None:
    copied = type("Copied", (), dict(vars(cruise.Cruise)))  # as if written in a notebook
    copied.__module__ = "__main__"
    forms = ["cruise", f"{cruise.__file__}:Cruise", cruise.Cruise, cruise.Cruise(), copied]

    runs = [score(form) for form in forms]

    assert len({run.path for run in runs}) == 4, "the class is found by its name"
    assert all(driven(run) == driven(runs[0]) for run in runs)
    assert driven(runs[0])[0]["completion"] > 0.5


def test_isolated_planner_scores_the_same() -> None:
    here = score("cruise", out="here")
    apart = score("cruise", out="apart", isolate=True)
    assert driven(here) == driven(apart)


def test_last_shard_completes_the_run(place: Path) -> None:
    first = score("cruise", repetitions=2, out="run", shard="1/2")
    assert len(first.results) == 1
    assert not (place / "run" / "summary.json").exists()

    last = score("cruise", repetitions=2, out="run", shard="2/2")

    assert len(last.results) == 2
    assert (
        last.summary.episodes
        == json.loads((place / "run" / "summary.json").read_text())["episodes"]
        == 2
    )


def test_only_a_changed_class_is_driven_again() -> None:
    events: list[object] = []
    first = score(local_planner(1.0), on_event=events.append)
    assert sum(isinstance(event, EpisodeEnded) for event in events) == 1
    events.clear()

    assert score(local_planner(1.0), on_event=events.append) == first
    assert events == []

    changed = score(local_planner(2.0), on_event=events.append)
    assert sum(isinstance(event, EpisodeEnded) for event in events) == 1
    assert changed.results[0].duration < first.results[0].duration
    with pytest.raises(pb.InputError, match="holds another run"):
        score(local_planner(2.0), out=first.path)


def test_failing_planner_is_recorded_with_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    @dataclass
    class Failing:
        left: int
        inputs = frozenset()

        def reset(self, route: pb.Route | None) -> None:
            assert route is None

        def act(self, observation: pb.Observation) -> pb.Control:
            self.left -= 1
            if self.left < 0:
                message = "enough"
                raise RuntimeError(message)
            return pb.Control(1.0, 0.0)

    with caplog.at_level(logging.WARNING, "plant_bench"):
        run = score(Failing(3), repetitions=2)

    assert run.episodes["status"].tolist() == ["Failed - Agent crashed"] * 2
    durations = {result.duration for result in run.results}
    assert len(durations) == 1, "each episode begins with a fresh copy"
    assert "2 of 2 episodes ended with 'Failed - Agent crashed'" in caplog.text
    with pytest.raises(pb.AgentError, match="act raised RuntimeError: enough"):
        list(pb.drive(Failing(3), ROUTE, suite="short.json", density="light"))


def test_steps_of_drive_equal_the_recorded_episode(place: Path) -> None:
    spec = f"{EXAMPLE}:MyAgent"
    run = score(spec, out="run")
    (file,) = (place / "run" / "recordings").iterdir()
    recording = Recording.load(file)

    steps = list(pb.drive(spec, 0, suite="short.json", density="light"))

    assert len(steps) == len(recording)
    for step, scene, action in zip(steps, recording, recording.actions, strict=True):
        assert step.scene.tick == scene.tick
        assert step.scene.ego == scene.ego
        assert np.array_equal(step.scene.actors.ids, scene.actors.ids)
        assert np.array_equal(step.scene.actors.poses, scene.actors.poses)
        if step.action is None or action is None:
            assert step.action is action
        else:
            assert same_action(step.action, action)
    (result,) = run.results
    last = steps[-1]
    assert (last.status, last.completion) == (result.status, result.completion)
    assert all(step.status is None and step.observation is not None for step in steps[:-1])
    assert result.seed == repetition_seed(0, ROUTE, 0)


def test_breaking_out_of_drive_allows_another_drive() -> None:
    for _ in range(2):
        for step in pb.drive(local_planner(1.0), ROUTE, suite="short.json", density="light"):
            if step.scene.tick == 3:
                assert isinstance(step.action, pb.Control)
                break


def test_drive_suggests_a_route_for_an_unknown_name() -> None:
    with pytest.raises(pb.InputError, match="Did you mean short-0"):
        pb.drive("cruise", "short-1", suite="short.json")
