"""The network in ONNX Runtime answers as it does in PyTorch."""

import math
from pathlib import Path

import numpy as np
import pytest
import torch

from plant_bench.agents.plant.agent import PlanT, load_predictor
from plant_bench.agents.plant.config import GRAPH_FILE, SIZES, WEIGHTS_FILE, PlanTConfig, Size
from plant_bench.agents.plant.export import export_graph
from plant_bench.agents.plant.graph import ATTENTION, EXPLAIN, GraphPredictor
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.agents.plant.predictor import TorchPredictor
from plant_bench.agents.plant.weights import save_network
from plant_bench.errors import InputError
from plant_bench.features.inputs import SceneInput
from plant_bench.features.tokens import Tokens, TokenSpec
from plant_bench.inference import listen_to_passes

pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")


def scene_of(tokens: int, speed: float = 6.0, attributes: int = 6) -> SceneInput:
    rng = np.random.default_rng(tokens)
    return SceneInput(
        Tokens(
            rng.normal(scale=5.0, size=(tokens, attributes)).astype(np.float32),
            rng.integers(1, 4, tokens).astype(np.uint8),
            np.arange(tokens),
        ),
        float(tokens % 2),
        (15.0, -3.0),
        speed,
        13.0,
    )


@pytest.mark.parametrize("extras", [False, True])
def test_the_graph_is_the_network(
    tmp_path: Path, extras: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(SIZES, "mini", Size(2, 32, 2))
    torch.manual_seed(0)
    spec = TokenSpec(meetings=extras, tracks=extras)
    config = PlanTConfig(tokens=spec, speed_input=extras, limit_input=extras)
    save_network(PlanTNetwork(config), tmp_path)
    eager = load_predictor(tmp_path)
    assert isinstance(eager, TorchPredictor)
    export_graph(tmp_path)
    graph = load_predictor(tmp_path)
    sizes = [(tmp_path / name).stat().st_size for name in (GRAPH_FILE, WEIGHTS_FILE)]
    assert sizes[0] < 1.1 * sizes[1]  # both in half precision
    assert isinstance(graph, GraphPredictor)
    scenes = [scene_of(count, attributes=spec.attributes) for count in (0, 1, 2, 24)]
    withheld = scene_of(3, math.nan, spec.attributes)
    for scene in [*scenes, withheld]:  # without a number it is withheld
        np.testing.assert_allclose(graph.waypoints(scene), eager.waypoints(scene), atol=1e-4)
        np.testing.assert_allclose(graph.attention(scene), eager.attention(scene), atol=1e-4)
    assert tmp_path / "network.onnx" in PlanT(str(tmp_path)).files
    passes = listen_to_passes()
    for predictor in (eager, graph):
        predictor.waypoints(scene_of(7, attributes=spec.attributes))
        predictor.attention(scene_of(7, attributes=spec.attributes))  # explains, and is no plan
    assert [item.tokens for item in passes] == [7, 7]


def test_attention_is_computed_only_where_it_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(SIZES, "mini", Size(2, 32, 2))
    save_network(PlanTNetwork(PlanTConfig()), tmp_path)
    export_graph(tmp_path)
    session = onnxruntime.InferenceSession(tmp_path / GRAPH_FILE)
    scene = scene_of(5)
    feed = {
        "attributes": scene.tokens.attributes[None],
        "kinds": scene.tokens.kinds[None],
        "red": np.zeros(1, np.float32),
        "target": np.zeros((1, 2), np.float32),
    }
    shapes = [
        session.run([ATTENTION], feed | {EXPLAIN: np.array([explain])})[0].shape
        for explain in (False, True)
    ]
    assert shapes == [(1, 0), (1, 5)]


def test_a_broken_graph_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "network.onnx").write_bytes(b"nothing")
    with pytest.raises(InputError, match="Broken graph"):
        GraphPredictor(tmp_path / "network.onnx")
