"""The motion attributes in samples equal those that the planner computes while it drives."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float

from plant_bench.agents.plant import agent as planner
from plant_bench.agents.plant.agent import INTERVAL, PlanT
from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.agents.plant.network_files import save_network
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.features.network_inputs import SceneInput
from plant_bench.features.tokens import TokenSpec
from plant_bench.sensing.observe import Sensors
from plant_bench.training.encodings import load_encodings
from plant_bench.training.frame_store import load_frames
from plant_bench.training.frames import SAMPLE_TICKS
from plant_bench.training.learners import LearnerSpec
from plant_bench.world.route import PROTOCOL, Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import TICK, Scene
from tests.builders import make_actors, make_ego, make_scene

SPEC = TokenSpec(conflicts=True, motion=True, vulnerable=True)
TICKS = 260
FIRST_SAMPLE = 50  # tick
HEADING = 0.5  # of the route, radians


def scene_at(tick: int) -> Scene:
    """The ego, and actors that accelerate, turn, appear, disappear or appear late."""
    time = tick * TICK
    along = 2.0 + 8.0 * time
    cars = [
        (3, 14.0, 0.0, HEADING, 8.0 + 3.0 * math.sin(time)),
        (7, 5.0, 9.0, HEADING + 0.4 * time, 4.0),
        (9, -6.0, -4.0, HEADING - 0.1 * time**2, 6.0 - 0.3 * time),
        (11, 20.0, 3.0, 3.0 + 0.1 * time, 0.5 * time),  # its angle wraps
    ]
    there = [tick % 37 < 20, True, True, tick > 104]
    rows = np.array([car for car, seen in zip(cars, there, strict=True) if seen])
    forward = np.array([math.cos(HEADING), math.sin(HEADING)])
    left = np.array([-forward[1], forward[0]])
    places = (along + rows[:, 1:2]) * forward + rows[:, 2:3] * left
    wrapped = (rows[:, 3:4] + math.pi) % (2.0 * math.pi) - math.pi
    actors = make_actors(
        np.hstack((places, wrapped)), speeds=rows[:, 4], ids=rows[:, 0].astype(int)
    )
    x, y = (along * forward).tolist()
    return make_scene(tick, ego=make_ego(8.0, x=x, y=y, yaw=HEADING), actors=actors)


def record(path: Path, route: Route, *, every: int) -> Path:
    about = {"route": route.id, "route_checksum": route.checksum, "protocol": PROTOCOL}
    recorder = Recorder(path, about, every=every)
    for tick in range(TICKS):
        recorder.add(scene_at(tick))
    recorder.close()
    return path


class Listening:
    """Records its inputs, and plans to go straight ahead."""

    def __init__(self) -> None:
        self.given: list[SceneInput] = []

    def waypoints(self, given: SceneInput) -> Float[np.ndarray, "waypoints 2"]:
        self.given.append(given)
        return np.array([[4.0, 0.0], [8.0, 0.0], [12.0, 0.0], [16.0, 0.0]])

    def attention(self, given: SceneInput) -> Float[np.ndarray, " tokens"]:
        return np.zeros(len(given.tokens))


def told_while_driving(
    recording: Recording, route: Route, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> dict[int, SceneInput]:
    """Return the network inputs of the planner at each decision."""
    listening = Listening()
    monkeypatch.setattr(planner, "load_predictor", lambda _folder: listening)
    save_network(PlanTNetwork(PlanTConfig(tokens=SPEC)), folder)
    driver, place = PlanT(str(folder)), RouteProgress(route)
    driver.reset(None)
    sensors = Sensors(route, 0, driver.inputs)
    told = {}
    for tick in range(len(recording)):
        scene = recording[tick]
        place.follow(scene.ego.x, scene.ego.y)
        if tick % INTERVAL == 0:
            driver.act(sensors.observe(scene, place.progress, place.offset))
            told[tick] = listening.given[-1]
    return told


def test_motion_in_samples_equals_motion_while_driving(
    tmp_path: Path, route: Route, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "routes").mkdir()
    suite = {"format": 1, "routes": [route.to_payload()]}
    (tmp_path / "routes" / "suite.json").write_text(json.dumps(suite), encoding="utf-8")
    record(tmp_path / "episodes" / "a.parquet", route, every=SAMPLE_TICKS)
    whole = Recording.load(record(tmp_path / "whole.parquet", route, every=1))
    told = told_while_driving(whole, route, tmp_path / "model", monkeypatch)

    learner_spec = LearnerSpec("plant", PlanTOptions(PlanTConfig(tokens=SPEC)))
    encodings = load_encodings(load_frames([tmp_path]), learner_spec)

    samples, starts = encodings.packs[0].columns, encodings.starts[0]
    assert len(starts) > 11
    for row in range(len(starts) - 1):
        driven = told[FIRST_SAMPLE + row * SAMPLE_TICKS]
        mine = slice(starts[row], starts[row + 1])
        np.testing.assert_array_equal(samples["kinds"][mine], driven.tokens.kinds)
        np.testing.assert_allclose(
            samples["attributes"][mine], driven.tokens.attributes, rtol=1e-5, atol=1e-5
        )
        assert samples["target"][row] == pytest.approx(driven.target, abs=1e-5)
        assert samples["limit"][row] == pytest.approx(driven.limit, abs=1e-5)
    changes = samples["attributes"][:, -2:]
    assert (np.abs(changes).max(axis=0) > (2.0, 0.5)).all()  # motion is not trivially zero
