"""PlanT as a planner: stored weights, the contract, ranks, and unusable folders."""

import copy
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from plant_bench.agent import NextLight, Observation
from plant_bench.agent_check import check_agent
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.plant.agent import PlanT
from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.agents.plant.network_files import load_network, save_network
from plant_bench.agents.plant.predictor import TorchPredictor
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenSpec
from plant_bench.world.route import load_suite
from plant_bench.world.scene import Light
from tests.builders import make_actors, make_ego, make_observation, straight_route_ahead


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    torch.manual_seed(0)
    path = tmp_path / "model"
    save_network(PlanTNetwork(PlanTConfig(tokens=TokenSpec(reach=25.0))), path)
    return path


def observation() -> Observation:
    return make_observation(
        ego=make_ego(4.0),
        speed_limit=9.0,
        actors=make_actors(
            [(10.0, 0.0), (60.0, 0.0), (5.0, 3.0), (40.0, 0.0)], speeds=1.0, extents=(1.0, 1.0)
        ),
        route=straight_route_ahead(49, speed_limits=9.0),
        light=NextLight(Light.RED, 20.0),
    )


def test_plant_satisfies_the_contract(folder: Path) -> None:
    agent = load_agent(f"plant@{folder}")
    check_agent(agent, load_suite("longest6")[0], [observation()] * 2)


def driven(steps: int = 12) -> list[Observation]:
    """Return over a second at 10 Hz in which the first actor accelerates and turns."""
    seen = []
    for step in range(steps):
        first = observation()
        actors = first.actors
        assert actors is not None
        speeds, poses = actors.speeds.copy(), actors.poses.copy()
        speeds[0], poses[0, 2] = 0.3 * step, 0.05 * step
        seen.append(
            replace(first, time=0.1 * step, actors=replace(actors, speeds=speeds, poses=poses))
        )
    return seen


@pytest.fixture
def tracking(tmp_path: Path) -> PlanT:
    torch.manual_seed(0)
    spec = TokenSpec(conflicts=True, motion=True)
    save_network(PlanTNetwork(PlanTConfig(tokens=spec)), tmp_path / "tracking")
    return PlanT(str(tmp_path / "tracking"))


def test_reset_clears_the_memory_of_plant(tracking: PlanT) -> None:
    check_agent(tracking, load_suite("longest6")[0], driven())


def test_memory_changes_the_plan_and_a_copy_does_not_affect_it(tracking: PlanT) -> None:
    *before, last = driven()
    fresh = tracking.act(last).waypoints
    tracking.reset(None)
    for seen in before:
        tracking.act(seen)
    other = copy.deepcopy(tracking)
    other.act(replace(last, actors=observation().actors, time=last.time + 0.4))
    known = tracking.act(last).waypoints

    assert not np.allclose(known, fresh)
    tracking.reset(None)
    for seen in before:
        tracking.act(seen)
    np.testing.assert_array_equal(tracking.act(last).waypoints, known)


@pytest.mark.parametrize(
    ("speed", "metres", "light", "ticks"),
    [
        (0.0, 0.0, None, 4),
        (0.0, 0.6, None, 4),  # too slow a plan for the pedals to set off
        (0.0, 3.0, None, 2),
        (2.0, 0.0, None, 2),
        (0.0, 0.0, Light.GREEN, 4),
        (0.0, 0.0, Light.RED, 8),
    ],
)
def test_plant_decides_less_often_while_it_stays_stationary(
    tracking: PlanT,
    monkeypatch: pytest.MonkeyPatch,
    speed: float,
    metres: float,
    light: Light | None,
    ticks: int,
) -> None:
    plan = np.linspace((0.0, 0.0), (metres, 0.0), 4)
    monkeypatch.setattr(TorchPredictor, "waypoints", lambda *_: plan)
    shown = None if light is None else NextLight(light, 5.0)
    scene = replace(observation(), ego=make_ego(speed), light=shown)
    tracking.act(scene)
    assert tracking.interval == ticks
    tracking.reset(None)
    assert tracking.interval == 2


def test_actors_without_a_token_rank_last(folder: Path) -> None:
    ranks = PlanT(str(folder)).rank(observation())
    assert set(np.argsort(-ranks)[:2].tolist()) == {0, 2}
    assert np.argsort(-ranks)[2:].tolist() == [3, 1]


def test_weights_are_stored_in_half_precision(folder: Path) -> None:
    network = load_network(folder)
    assert network.config == PlanTConfig(tokens=TokenSpec(reach=25.0))
    assert all(v.dtype == torch.float16 for v in load_file(folder / "weights.safetensors").values())
    assert {weights.dtype for weights in network.parameters()} == {torch.float32}
    save_network(network, folder.with_name("again"))
    again = (folder.with_name("again") / "weights.safetensors").read_bytes()
    assert again == (folder / "weights.safetensors").read_bytes()


def test_checksum_covers_the_weights(folder: Path) -> None:
    before = agent_checksum(f"plant@{folder}")
    torch.manual_seed(1)
    save_network(PlanTNetwork(PlanTConfig(tokens=TokenSpec(reach=25.0))), folder)
    assert agent_checksum(f"plant@{folder}") != before


def cut(folder: Path) -> None:
    path = folder / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:-1000])


def forget(folder: Path) -> None:
    (folder / "config.json").unlink()


def resize(folder: Path) -> None:
    path = folder / "config.json"
    path.write_text(path.read_text().replace('"mini"', '"small"'))


def misname(folder: Path) -> None:
    path = folder / "config.json"
    path.write_text(path.read_text().replace('"mini"', '"huge"'))


def age(folder: Path) -> None:
    path = folder / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"format": 0}))


def move_to_another_world(folder: Path) -> None:
    path = folder / "config.json"
    path.write_text(path.read_text().replace('"longest6-sumo-', '"other-'))


def spoil(folder: Path) -> None:
    path = folder / "weights.safetensors"
    state = load_file(path)
    state["cls"] = torch.full_like(state["cls"], torch.nan)
    save_file(state, path)


@pytest.mark.parametrize(
    ("harm", "message"),
    [
        (cut, "Cannot use the weights"),
        (forget, "There are no weights in"),
        (resize, "size mismatch for"),
        (misname, "Not the config"),
        (age, "expected format 2 of network 'plant', got format 0 of 'plant'"),
        (move_to_another_world, "trained under protocol 'other-"),
        (spoil, "not finite"),
    ],
)
def test_unusable_weights_raise_input_error(folder: Path, harm, message: str) -> None:
    harm(folder)
    with pytest.raises(InputError, match=message):
        load_agent(f"plant@{folder}")


def test_other_planners_do_not_import_torch() -> None:
    code = (
        "import sys; from plant_bench.agents.loading.registry import agent_factory, load_agent\n"
        "load_agent('rule-based'); print(agent_factory('plant').__doc__); import plant_bench.cli\n"
        "assert 'torch' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
