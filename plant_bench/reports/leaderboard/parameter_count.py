"""How many parameters a planner's network has: read from the head of its weights, without torch."""

import math
import struct
from pathlib import Path

from plant_bench.agents.plant.agent import DEFAULT_WEIGHTS
from plant_bench.data_files import models_dir
from plant_bench.untrusted_files import parse_json

SHIPPED = dict.fromkeys(("plant", "plant-unguarded"), DEFAULT_WEIGHTS)  # without a folder's name
SUFFIX = ".safetensors"
LONGEST_HEAD = 100_000_000  # bytes, as the format's own readers allow


def parameter_count(agent: str) -> int | None:
    """Return the number of parameters of the weights that an agent's name tells of.

    Args:
        agent: As it was asked for; what follows an "@" is a folder of weights or a file.

    Returns:
        None where it names no weights, or they are not there any more.
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
    """Return the elements of all tensors of a safetensors file, None if it is broken."""
    try:
        with file.open("rb") as data:
            (length,) = struct.unpack("<Q", data.read(8))
            head = parse_json(data.read(min(length, LONGEST_HEAD)).decode())
        return sum(
            math.prod(tensor["shape"]) for name, tensor in head.items() if name != "__metadata__"
        )
    except (OSError, ValueError, struct.error, KeyError, TypeError, AttributeError):
        return None
