"""Counts a network's parameters from the header of its safetensors file, without torch."""

import math
import struct
from pathlib import Path

from plant_bench.agents.plant.agent import DEFAULT_WEIGHTS
from plant_bench.data_files import models_dir
from plant_bench.untrusted_files import parse_json

SHIPPED = dict.fromkeys(("plant", "plant-unguarded"), DEFAULT_WEIGHTS)  # names without "@FOLDER"
SUFFIX = ".safetensors"
LONGEST_HEADER = 100_000_000  # bytes, the limit of the safetensors library


def parameter_count(agent: str) -> int | None:
    """Return the number of parameters of the weights that an agent's name refers to.

    Args:
        agent: The agent as given by the user; after an "@" follows a folder of weights or a file.

    Returns:
        None if it refers to no weights, or they do not exist any more.
    """
    name, _, argument = agent.rpartition("@") if "@" in agent else (agent, "", "")
    place = Path(argument) if argument else None
    if place is None and name in SHIPPED:
        place = models_dir() / SHIPPED[name]
    files = [] if place is None else _weight_files(place)
    counts = [count for file in files if (count := _count(file)) is not None]
    return sum(counts) if counts else None


def _weight_files(place: Path) -> list[Path]:
    try:
        if place.is_dir():
            return sorted(place.glob(f"*{SUFFIX}"))
        return [place] if place.suffix == SUFFIX and place.is_file() else []
    except OSError:  # a name too long to be a path
        return []


def _count(file: Path) -> int | None:
    """Return the number of elements of all tensors in a safetensors file, None if it is broken."""
    try:
        with file.open("rb") as data:
            (length,) = struct.unpack("<Q", data.read(8))
            header = parse_json(data.read(min(length, LONGEST_HEADER)).decode())
        return sum(
            math.prod(tensor["shape"]) for name, tensor in header.items() if name != "__metadata__"
        )
    except (OSError, ValueError, struct.error, KeyError, TypeError, AttributeError):
        return None
