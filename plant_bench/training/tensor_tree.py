"""Stores nested dicts and lists with tensors in one safetensors file, without pickle."""

import json
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open

from plant_bench.model_folder import save_tensors
from plant_bench.untrusted_files import check_file

LARGEST = 8_000_000_000  # bytes
_TREE, _TENSOR, _PAIRS = "tree", "tensor", "pairs"


def save_tree(value: Any, path: Path) -> None:
    """Write nested dicts, lists, numbers, strings and tensors; tuples become lists.

    Raises:
        OSError: The file cannot be written.
    """
    tensors: dict[str, torch.Tensor] = {}
    text = json.dumps(_packed(value, tensors))
    save_tensors(tensors, path, {_TREE: text})


def load_tree(path: Path) -> Any:
    """Read a file that `save_tree` wrote.

    Raises:
        OSError: The file cannot be read.
        ValueError: The file is broken, or was not written by `save_tree`.
    """
    check_file(path, largest=LARGEST)
    try:
        with safe_open(path, framework="pt", device="cpu") as file:
            text = (file.metadata() or {})[_TREE]
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        return _unpacked(json.loads(text), tensors)
    except (SafetensorError, KeyError, TypeError, AttributeError, RecursionError) as error:
        message = str(error).partition("\n")[0] or "it is nested too deeply"
        raise ValueError(message) from error


def _packed(value: Any, tensors: dict[str, torch.Tensor]) -> Any:
    if isinstance(value, torch.Tensor):
        name = str(len(tensors))
        tensors[name] = value.detach().to("cpu").contiguous().clone()
        return {_TENSOR: name}
    if isinstance(value, dict):  # as pairs, since keys may be numbers
        return {_PAIRS: [[key, _packed(item, tensors)] for key, item in value.items()]}
    if isinstance(value, list | tuple):
        return [_packed(item, tensors) for item in value]
    return value


def _unpacked(value: Any, tensors: dict[str, torch.Tensor]) -> Any:
    if isinstance(value, list):
        return [_unpacked(item, tensors) for item in value]
    if not isinstance(value, dict):
        return value
    if _TENSOR in value:
        return tensors[value[_TENSOR]]
    return {key: _unpacked(item, tensors) for key, item in value[_PAIRS]}
