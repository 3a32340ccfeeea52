"""Saves and loads any trained network: `weights.safetensors` and `config.json` in a folder.

The config holds the network's name, which is checked when it is loaded, and the protocol that it
was trained under. Torch is imported only when weights are written or read.
"""

import errno
import hashlib
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from plant_bench.atomic_files import whole_file, write_whole_text
from plant_bench.errors import InputError, in_one_line
from plant_bench.untrusted_files import check_file, read_json
from plant_bench.world.route import PROTOCOL

if TYPE_CHECKING:
    from torch import Tensor
    from torch.nn import Module
else:  # torch is not loaded for type annotations only
    Tensor = Module = Any

WEIGHTS_FILE, CONFIG_FILE = "weights.safetensors", "config.json"
MODEL_FORMAT = 2
LARGEST_WEIGHTS = 1_000_000_000  # bytes; PlanT's size MEDIUM takes 60 million

Config = TypeVar("Config")


def save_model(
    network_name: str, config: Mapping[str, Any], state: Mapping[str, Tensor], folder: Path
) -> None:
    """Write weights (half precision) and config, each file atomically.

    Args:
        network_name: The network's name; loading under another name is an error.
        config: The network's config, JSON-serialisable.
        state: The network's weights.
        folder: The model folder.

    Raises:
        OSError: Writing failed, for instance because the disk is full.
    """
    import torch

    about = {"format": MODEL_FORMAT, "network": network_name, "protocol": PROTOCOL, **config}
    halved = {
        name: values.detach().to("cpu", torch.float16 if values.is_floating_point() else None)
        for name, values in state.items()
    }
    write_whole_text(folder / CONFIG_FILE, json.dumps(about, indent=1) + "\n")
    with whole_file(folder / WEIGHTS_FILE) as part:
        save_tensors({name: values.contiguous() for name, values in halved.items()}, part)


def save_tensors(
    tensors: dict[str, Tensor], path: Path, metadata: dict[str, str] | None = None
) -> None:
    """Write a safetensors file that is readable by all users.

    Raises:
        OSError: Writing failed, for instance because the disk is full.
    """
    from safetensors import SafetensorError
    from safetensors.torch import save_file

    try:
        save_file(tensors, path, metadata=metadata)
    except SafetensorError as error:  # also for a full disk
        raise OSError(errno.EIO, in_one_line(error), str(path)) from error
    path.chmod(0o644)  # safetensors creates it as 0600


def weights_hash(folder: Path) -> str:
    """Return a hash of a model folder's weights.

    Raises:
        InputError: There are no weights.
    """
    try:
        check_file(folder / WEIGHTS_FILE, largest=LARGEST_WEIGHTS)
        return hashlib.sha256((folder / WEIGHTS_FILE).read_bytes()).hexdigest()[:16]
    except (OSError, ValueError) as error:
        message = f"There are no weights in {folder}: expected a model folder."
        raise InputError(message) from error


def read_config(
    folder: Path, network_name: str, made_from: Callable[[dict[str, Any]], Config]
) -> Config:
    """Return a model folder's config.

    Args:
        folder: The model folder.
        network_name: The name under which the network was saved.
        made_from: Creates the config from the values; raises ValueError if they are invalid.

    Raises:
        InputError: It is missing or broken, or has another network, format or protocol.
    """
    path = folder / CONFIG_FILE
    try:
        about = read_json(path)
        _check_header(about.pop("format"), about.pop("network"), network_name)
        if (protocol := about.pop("protocol")) != PROTOCOL:
            message = f"trained under protocol '{protocol}', expected '{PROTOCOL}': train again"
            raise ValueError(message)
        return made_from(about)
    except FileNotFoundError as error:
        message = (
            f"There are no weights in {folder}: `plant-bench train {network_name} --out {folder}` "
            "creates them; `--agent NAME@FOLDER` uses those of another folder."
        )
        raise InputError(message) from error
    except (OSError, KeyError, ValueError, AttributeError, TypeError) as error:
        message = f"Not the config of a '{network_name}' network: {path} ({in_one_line(error)})."
        raise InputError(message) from error


def _check_header(number: object, network: object, network_name: str) -> None:
    if number != MODEL_FORMAT or network != network_name:
        message = (
            f"expected format {MODEL_FORMAT} of network '{network_name}', "
            f"got format {number} of '{network}'"
        )
        raise ValueError(message)


def load_weights(network: Module, folder: Path) -> None:
    """Load a model folder's weights into a network.

    Raises:
        InputError: They are missing or broken, have other shapes, or are not finite.
    """
    fill(network, load_state(folder), folder)


def load_state(folder: Path) -> dict[str, Tensor]:
    """Return a folder's weights by name, in single precision.

    Raises:
        InputError: They are missing or broken, or are not finite.
    """
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    path = folder / WEIGHTS_FILE
    try:
        check_file(path, largest=LARGEST_WEIGHTS)
        found = load_file(path)
        state = {name: _single(values) for name, values in found.items()}
    except (OSError, SafetensorError, RuntimeError, ValueError, TypeError) as error:
        raise _useless(path, error) from error
    if not all(math.isfinite(values.sum()) for values in state.values()):
        message = f"The weights {path} have values that are not finite: train again."
        raise InputError(message)
    return state


def fill(network: Module, state: Mapping[str, Tensor], folder: Path) -> None:
    """Load weights into a network; `folder` appears only in the error message.

    Raises:
        InputError: Their names or shapes do not match.
    """
    try:
        network.load_state_dict(state)
    except (RuntimeError, ValueError, TypeError) as error:
        raise _useless(folder / WEIGHTS_FILE, error) from error


def _single(values: Tensor) -> Tensor:
    return values.float() if values.is_floating_point() else values


def _useless(path: Path, error: Exception) -> InputError:
    return InputError(
        f"Cannot use the weights {path}: {in_one_line(error)} Get the file again, or train again."
    )
