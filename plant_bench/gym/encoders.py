"""Observations as arrays of a fixed size. Nothing privileged: each sees what a planner is given."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from gymnasium import spaces
from jaxtyping import UInt8

from plant_bench.agent import Observation
from plant_bench.errors import InputError
from plant_bench.features.raster import Rasteriser, RasterSpec
from plant_bench.gym.object_encoder import ObjectEncoder
from plant_bench.gym.token_encoder import TokenEncoder
from plant_bench.sensing.inputs import DRIVER_ONLY, PERCEIVED
from plant_bench.world.town import Town


@runtime_checkable
class Encoder(Protocol):
    """Turns what is seen into arrays; may remember the episode.

    One with an attribute `inputs` is given these, as a planner that declares them, else what
    `plant_bench.sensing.inputs.PERCEIVED` lists.
    """

    @property
    def space(self) -> spaces.Space[Any]:
        """What `encode` returns is in it."""
        ...

    def reset(self, town: Town) -> None:
        """Start a new episode in a town."""
        ...

    def encode(self, observation: Observation) -> Any:
        """Return new arrays for the next observation."""
        ...


class RasterEncoder:
    """The bird's-eye view.

    Args:
        spec: What is drawn.
    """

    def __init__(self, spec: RasterSpec | None = None) -> None:
        self._spec = spec or RasterSpec()
        shape = (len(self._spec.channels), self._spec.size, self._spec.size)
        self.space = spaces.Box(0, 255, shape, np.uint8)
        self._rasteriser: Rasteriser | None = None

    def reset(self, town: Town) -> None:
        """Forget what was seen, and draw another town from now on."""
        self._rasteriser = Rasteriser(town, self._spec)

    def encode(self, observation: Observation) -> UInt8[np.ndarray, "channels size size"]:
        """Return the picture.

        Raises:
            InputError: There was no reset.
        """
        if self._rasteriser is None:
            message = "A raster knows no town before reset(town)."
            raise InputError(message)
        return self._rasteriser.draw(observation)


ENCODERS: dict[str, type[TokenEncoder] | type[ObjectEncoder] | type[RasterEncoder]] = {
    "tokens": TokenEncoder,
    "objects": ObjectEncoder,
    "raster": RasterEncoder,
}


def encoder_of(wanted: object) -> Encoder:
    """Return an encoder by its name, or the one given.

    Raises:
        InputError: There is none of this name, or it is no encoder.
    """
    if isinstance(wanted, str):
        if wanted not in ENCODERS:
            message = f"There is no observation {wanted!r}. Observations: {', '.join(ENCODERS)}."
            raise InputError(message)
        return ENCODERS[wanted]()
    if not isinstance(wanted, Encoder):
        message = f"{wanted!r} is no observation: space, reset and encode are wanted, or a name."
        raise InputError(message)
    if refused := encoder_inputs(wanted) & DRIVER_ONLY:
        message = (
            f"{wanted!r} asks for {' and '.join(sorted(refused))}: nothing privileged is given."
        )
        raise InputError(message)
    return wanted


def encoder_inputs(encoder: Encoder) -> frozenset[str]:
    """Return what an encoder is to be given, as planners declare it."""
    return frozenset(getattr(encoder, "inputs", PERCEIVED))
