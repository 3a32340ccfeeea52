"""PlanT's network config: size, inputs, and bins of the auxiliary task. Needs no torch."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter

from plant_bench.features.tokens import TokenSpec
from plant_bench.model_folder import read_config
from plant_bench.renamed import renamed_keys

SizeName = Literal["mini", "small", "medium"]
GraphBits = Literal[8, 32]  # bits per weight of the encoder in an ONNX graph

NETWORK = "plant"  # as a model's config names it
GRAPH_FILE = "network.onnx"

TOP_SPEED = 60.0 / 3.6  # m/s, of the bins (PlanT, dataset.py)
LARGEST_EXTENT = 30.0  # m, of the bins (PlanT, dataset.py)
SPEED_BINS, PLACE_BINS, YAW_BINS = 4, 128, 32  # Z_a (PlanT, "Implementation")


@dataclass(frozen=True)
class Size:
    """An encoder's size.

    Attributes:
        layers: Number of transformer layers.
        width: Hidden width H.
        heads: Number of attention heads.
    """

    layers: int
    width: int
    heads: int


SIZES: dict[SizeName, Size] = {  # Turc et al., 2019
    "mini": Size(4, 256, 4),
    "small": Size(4, 512, 8),
    "medium": Size(8, 512, 8),
}

GRAPH_BITS: GraphBits = 8  # MEDIUM is too slow in float32, and MINI is a third faster


@dataclass(frozen=True)
class Bins:
    """How one attribute is divided into classes.

    Attributes:
        count: Number of bins.
        low: The lowest bin's centre; lower values belong to it, too.
        high: The highest bin's centre; higher values belong to it, too.
    """

    count: int
    low: float
    high: float


@dataclass(frozen=True)
class PlanTConfig:
    """A network's shape and inputs; stored beside its weights.

    Attributes:
        size: Size of the transformer encoder, as named by Turc et al. (2019).
        tokens: Which objects become tokens.
        speed_input: Whether the ego's speed is an input. Not in PlanT: with it, imitation learns
            to keep the present speed, and a stationary ego never starts.
        speed_dropout: Share of the training samples whose speed input is dropped.
        limit_input: Whether the highest speed that complies with all speed limits ahead is an
            input. Not in PlanT.
    """

    size: SizeName = "mini"
    tokens: TokenSpec = field(default_factory=TokenSpec)
    speed_input: bool = False
    speed_dropout: float = field(default=0.5, metadata={"min": 0.0, "max": 1.0})
    limit_input: bool = False

    @property
    def encoder(self) -> Size:
        """The encoder's size."""
        return SIZES[self.size]

    @property
    def bins(self) -> tuple[Bins, ...]:
        """The bins of z, x, y, yaw, width and length for the auxiliary task."""
        place = Bins(PLACE_BINS, -self.tokens.reach, self.tokens.reach)
        extent = Bins(PLACE_BINS, 0.0, LARGEST_EXTENT)
        yaw = Bins(YAW_BINS, -math.pi, math.pi)
        return Bins(SPEED_BINS, 0.0, TOP_SPEED), place, place, yaw, extent, extent


def load_config(folder: Path) -> PlanTConfig:
    """Read a network's config.

    Raises:
        InputError: It is missing or broken, or has another format or protocol.
    """
    return read_config(folder, NETWORK, config_from)


def config_from(values: Mapping[str, Any]) -> PlanTConfig:
    """Return the config from the values in a model's file.

    Raises:
        ValueError: Values are missing, of other types or out of range.
    """
    if message := renamed_keys(values.get("tokens", {})):
        raise ValueError(message)
    config = TypeAdapter(PlanTConfig).validate_python(dict(values))
    _check_ranges(config)
    return config


def _check_ranges(config: PlanTConfig) -> None:
    """Raise ValueError for a value out of range."""
    tokens = config.tokens
    ranges = {
        "reach": (tokens.reach, 1.0, 1000.0),
        "horizon": (tokens.horizon, 0.0, 60.0),
        "segments": (tokens.segments, 0, 1000),
        "longest": (tokens.longest, 0.1, 1000.0),
        "tolerance": (tokens.tolerance, 0.0, 100.0),
        "view": (tokens.view, 1, 1000),
        "speed_dropout": (config.speed_dropout, 0.0, 1.0),
    }
    for name, (value, low, high) in ranges.items():
        if not low <= value <= high:
            message = f"{name}: expected {low} to {high}, got {value}"
            raise ValueError(message)
