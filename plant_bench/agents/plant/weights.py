"""A trained network on disk: a folder with `weights.safetensors` (half precision) and a config."""

import errno
import hashlib
import json
import math
from dataclasses import asdict
from pathlib import Path

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file

from plant_bench.agents.plant.config import (
    CONFIG_FILE,
    WEIGHTS_FILE,
    WEIGHTS_FORMAT,
    load_config,
)
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.errors import InputError, in_one_line
from plant_bench.input_files import check_file
from plant_bench.whole_files import whole_file, write_whole_text
from plant_bench.world.route import PROTOCOL

LARGEST_WEIGHTS = 1_000_000_000  # bytes; MEDIUM has 60 million


def save_network(network: PlanTNetwork, folder: Path) -> None:
    """Write a network's weights and config, each file whole or not at all."""
    facts = {"format": WEIGHTS_FORMAT, "network": "plant", "protocol": PROTOCOL}
    payload = {**facts, **asdict(network.config)}
    text = json.dumps(payload, indent=1) + "\n"
    state = {
        name: values.detach().to("cpu", torch.float16).contiguous()
        for name, values in network.state_dict().items()
    }
    write_whole_text(folder / CONFIG_FILE, text)
    with whole_file(folder / WEIGHTS_FILE) as part:
        save_tensors(state, part)


def save_tensors(
    tensors: dict[str, torch.Tensor], path: Path, metadata: dict[str, str] | None = None
) -> None:
    """Write a safetensors file that others may read, too.

    Raises:
        OSError: The disk is full, or it cannot be written for another reason.
    """
    try:
        save_file(tensors, path, metadata=metadata)
    except SafetensorError as error:  # also for a full disk
        raise OSError(errno.EIO, in_one_line(error), str(path)) from error
    path.chmod(0o644)  # safetensors makes it private


def weights_hash(folder: Path) -> str:
    """Return a hash of a folder's weights.

    Raises:
        InputError: There are none.
    """
    try:
        check_file(folder / WEIGHTS_FILE, largest=LARGEST_WEIGHTS)
        return hashlib.sha256((folder / WEIGHTS_FILE).read_bytes()).hexdigest()[:16]
    except (OSError, ValueError) as error:
        message = f"There are no weights in {folder}: a model's folder is wanted."
        raise InputError(message) from error


def load_network(folder: Path) -> PlanTNetwork:
    """Read a network, ready to plan: float32, dropout off.

    Raises:
        InputError: Files are missing or broken, or the weights do not fit the config.
    """
    config = load_config(folder)
    path = folder / WEIGHTS_FILE
    try:
        check_file(path, largest=LARGEST_WEIGHTS)
        state = {name: values.float() for name, values in load_file(path).items()}
        network = PlanTNetwork(config)
        network.load_state_dict(state)
    except (OSError, SafetensorError, RuntimeError, ValueError, TypeError) as error:
        message = (
            f"Cannot use the weights {path} as a PlanT of size '{config.size}': "
            f"{in_one_line(error)} Get the file again, or train anew."
        )
        raise InputError(message) from error
    if not all(math.isfinite(values.sum()) for values in state.values()):
        message = f"The weights {path} hold values that are not finite: train anew."
        raise InputError(message)
    return network.eval()
