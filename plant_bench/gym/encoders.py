"""Observation encoders: fixed-size arrays from observations, without privileged inputs."""

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
    """Converts observations into arrays; may keep state within an episode.

    An attribute `inputs` declares its inputs, as for planners; the default is
    `plant_bench.sensing.inputs.PERCEIVED`.
    """

    @property
    def space(self) -> spaces.Space[Any]:
        """The space of the encoded observations."""
        ...

    def reset(self, town: Town) -> None:
        """Start a new episode in a town."""
        ...

    def encode(self, observation: Observation) -> Any:
        """Return new arrays for the next observation."""
        ...


class RasterEncoder:
    """The bird's-eye view as an image with one channel per layer.

    Args:
        spec: Size, scale and channels. Default: `RasterSpec()`.
    """

    def __init__(self, spec: RasterSpec | None = None) -> None:
        self._spec = spec or RasterSpec()
        shape = (len(self._spec.channels), self._spec.size, self._spec.size)
        self.space = spaces.Box(0, 255, shape, np.uint8)
        self._rasteriser: Rasteriser | None = None

    def reset(self, town: Town) -> None:
        """Start a new episode in a town."""
        self._rasteriser = Rasteriser(town, self._spec)

    def encode(self, observation: Observation) -> UInt8[np.ndarray, "channels size size"]:
        """Return the raster.

        Raises:
            InputError: `reset` has not been called.
        """
        if self._rasteriser is None:
            message = "The raster encoder has no town: call reset(town) first."
            raise InputError(message)
        return self._rasteriser.draw(observation)


ENCODERS: dict[str, type[TokenEncoder] | type[ObjectEncoder] | type[RasterEncoder]] = {
    "tokens": TokenEncoder,
    "objects": ObjectEncoder,
    "raster": RasterEncoder,
}


def encoder_of(encoder: object) -> Encoder:
    """Return an encoder by its name; an encoder object is returned as it is.

    Raises:
        InputError: There is no encoder of this name, or the object is not an encoder.
    """
    if isinstance(encoder, str):
        if encoder not in ENCODERS:
            message = f"There is no observation {encoder!r}. Observations: {', '.join(ENCODERS)}."
            raise InputError(message)
        return ENCODERS[encoder]()
    if not isinstance(encoder, Encoder):
        message = f"Observation: expected a name, or space, reset and encode, got {encoder!r}."
        raise InputError(message)
    if refused := encoder_inputs(encoder) & DRIVER_ONLY:
        message = (
            f"Observation: expected an encoder without privileged inputs, got {encoder!r}, which "
            f"declares {' and '.join(sorted(refused))}."
        )
        raise InputError(message)
    return encoder


def encoder_inputs(encoder: Encoder) -> frozenset[str]:
    """Return the inputs that an encoder declares, or the default."""
    return frozenset(getattr(encoder, "inputs", PERCEIVED))
