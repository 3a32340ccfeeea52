"""Renders the bird's-eye view as a colour image, for `render()`."""

import numpy as np
from jaxtyping import UInt8

from plant_bench.agent import Observation
from plant_bench.features.raster import ROACH, Rasteriser, RasterSpec
from plant_bench.features.raster_layers import Layer
from plant_bench.world.town import Town

VIEW = RasterSpec(
    size=512,
    scale=8.0,
    below=176,
    layers=(*ROACH.layers, Layer.EGO),
)
GROUND = (233, 236, 239)
COLOURS = {
    Layer.ROAD: (173, 181, 189),
    Layer.ROUTE: (165, 216, 255),
    Layer.LANE_LINES: (248, 249, 250),
    Layer.VEHICLES: (73, 80, 87),
    Layer.VULNERABLE: (247, 103, 7),
    Layer.EGO: (25, 113, 194),
}
LIGHT_COLOURS = {80: (47, 158, 68), 170: (240, 140, 0), 255: (224, 49, 49)}


def picture(town: Town, observation: Observation) -> UInt8[np.ndarray, "height width 3"]:
    """Return an image of a scene, with the ego facing upwards."""
    layers = Rasteriser(town, VIEW).draw(observation)
    shown = np.empty((VIEW.size, VIEW.size, 3), np.uint8)
    shown[:] = GROUND
    for layer, values in zip(VIEW.layers, layers, strict=True):
        if layer is Layer.LIGHTS:
            for value, colour in LIGHT_COLOURS.items():
                shown[values == value] = colour
        else:
            shown[values > 0] = COLOURS[layer]
    return shown
