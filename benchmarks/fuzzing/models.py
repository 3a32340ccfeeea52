"""Fuzzing of networks and training files: valid files and their readers."""

import tempfile
from pathlib import Path

from fuzzing.form import Format, used


def _small() -> None:
    """Let PlanT's smallest size be a tiny one, so that its files are quick to break."""
    from plant_bench.agents.plant.config import SIZES, Size

    SIZES["mini"] = Size(1, 32, 2)


def _put_model(box: Path) -> None:
    from plant_bench.agents.plant.config import PlanTConfig
    from plant_bench.agents.plant.network import PlanTNetwork
    from plant_bench.agents.plant.network_files import save_network

    _small()
    save_network(PlanTNetwork(PlanTConfig()), box / "model")


def _model_file(name: str) -> bytes:
    with tempfile.TemporaryDirectory() as place:
        _put_model(Path(place))
        if name.endswith(".onnx"):
            from plant_bench.agents.plant.onnx_export import export_graph

            export_graph(Path(place) / "model", 32)
        return (Path(place) / "model" / name).read_bytes()


def _use_config(box: Path) -> None:
    from plant_bench.agents.plant.config import load_config

    config = load_config(box / "model")
    used(config.bins)
    used(config.encoder)


def _use_weights(box: Path) -> None:
    from plant_bench.agents.plant.network_files import load_network
    from plant_bench.model_folder import weights_hash
    from plant_bench.reports.leaderboard.parameter_count import parameter_count

    weights_hash(box / "model")
    parameter_count(f"x@{box / 'model'}")
    load_network(box / "model")


def _use_graph(box: Path) -> None:
    from plant_bench.agents.plant.onnx_network import GraphPredictor

    GraphPredictor(box / "model" / "network.onnx")


IDENTITY = {"data": "x"}


def _checkpoint_seeds() -> list[bytes]:
    import torch

    from plant_bench.training.checkpoint import CHECKPOINT_FILE, Progress, save_checkpoint

    network = torch.nn.Linear(3, 2)
    optimizer = torch.optim.AdamW(network.parameters())
    network(torch.ones(1, 3)).sum().backward()
    optimizer.step()
    with tempfile.TemporaryDirectory() as place:
        states = network.state_dict(), optimizer.state_dict()
        save_checkpoint(Path(place), Progress(1, 2), IDENTITY, *states)
        return [(Path(place) / CHECKPOINT_FILE).read_bytes()]


def _use_checkpoint(box: Path) -> None:
    from plant_bench.training.checkpoint import load_checkpoint

    load_checkpoint(box, IDENTITY)


FORMATS = (
    Format(
        "config", "json", "model/config.json", lambda: [_model_file("config.json")], _use_config,
        _put_model,
    ),
    Format(
        "weights", "safetensors", "model/weights.safetensors",
        lambda: [_model_file("weights.safetensors")], _use_weights, _put_model,
    ),
    Format(
        "onnx", "bytes", "model/network.onnx", lambda: [_model_file("network.onnx")], _use_graph,
        _put_model,
    ),
    Format(
        "checkpoint", "safetensors", "checkpoint.safetensors", _checkpoint_seeds, _use_checkpoint
    ),
)  # fmt: skip
