"""A trained network on disk, whichever it is: `weights.safetensors` and `config.json` in a folder.

The config names the network, so that none is loaded as another, and the protocol it was trained
under. Torch is loaded where weights are written or read, and not before.
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
else:  # torch is not loaded to look at a type
    Tensor = Module = Any

WEIGHTS_FILE, CONFIG_FILE = "weights.safetensors", "config.json"
MODEL_FORMAT = 2
LARGEST_WEIGHTS = 1_000_000_000  # bytes; PlanT's MEDIUM has 60 million

Config = TypeVar("Config")


def save_model(
    network_name: str, config: Mapping[str, Any], state: Mapping[str, Tensor], folder: Path
) -> None:
    """Write weights (half precision) and config, each file whole or not at all.

    Args:
        network_name: Of the network: who loads another one from here is refused.
        config: What the network is made from, as JSON-able values.
        state: Of the network.
        folder: Where to.

    Raises:
        OSError: The disk is full, or it cannot be written for another reason.
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
    """Write a safetensors file that others may read, too.

    Raises:
        OSError: The disk is full, or it cannot be written for another reason.
    """
    from safetensors import SafetensorError
    from safetensors.torch import save_file

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
        message = f"There are no weights in {folder}: a model's folder is expected."
        raise InputError(message) from error


def read_config(
    folder: Path, network_name: str, made_from: Callable[[dict[str, Any]], Config]
) -> Config:
    """Return what a folder's network is made from.

    Args:
        folder: Of the model.
        network_name: As it was saved.
        made_from: Makes it from the values; raises ValueError where they are of no use.

    Raises:
        InputError: There is none, or it is broken, of another network, format or protocol.
    """
    path = folder / CONFIG_FILE
    try:
        about = read_json(path)
        _check_header(about.pop("format"), about.pop("network"), network_name)
        if (protocol := about.pop("protocol")) != PROTOCOL:
            message = f"trained under the protocol '{protocol}'; this is '{PROTOCOL}': train anew"
            raise ValueError(message)
        return made_from(about)
    except FileNotFoundError as error:
        message = (
            f"There are no weights in {folder}: `plant-bench train {network_name} --out {folder}` "
            "makes them; with `--agent NAME@FOLDER` a planner takes those of another folder."
        )
        raise InputError(message) from error
    except (OSError, KeyError, ValueError, AttributeError, TypeError) as error:
        message = f"Not the config of a '{network_name}' network: {path} ({in_one_line(error)})."
        raise InputError(message) from error


def _check_header(number: object, network: object, network_name: str) -> None:
    if number != MODEL_FORMAT or network != network_name:
        message = (
            f"format {number} of network '{network}' found, "
            f"format {MODEL_FORMAT} of '{network_name}' expected"
        )
        raise ValueError(message)


def load_weights(network: Module, folder: Path) -> None:
    """Fill a network with a folder's weights.

    Raises:
        InputError: They are missing or broken, are of another shape, or are not finite.
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
        message = f"The weights {path} hold values that are not finite: train anew."
        raise InputError(message)
    return state


def fill(network: Module, state: Mapping[str, Tensor], folder: Path) -> None:
    """Put weights that came from a folder into a network.

    Raises:
        InputError: They do not fit.
    """
    try:
        network.load_state_dict(state)
    except (RuntimeError, ValueError, TypeError) as error:
        raise _useless(folder / WEIGHTS_FILE, error) from error


def _single(values: Tensor) -> Tensor:
    return values.float() if values.is_floating_point() else values


def _useless(path: Path, error: Exception) -> InputError:
    return InputError(
        f"Cannot use the weights {path}: {in_one_line(error)} Get the file again, or train anew."
    )
