"""A planner on pixels as an external author would write it: agent and learner in one file."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import torch
from pydantic import TypeAdapter
from torch import nn

from plant_bench.agent import Input, Plan
from plant_bench.features.raster import Rasteriser, RasterSpec
from plant_bench.features.raster_layers import Layer
from plant_bench.learner import Choice, Learner
from plant_bench.model_folder import load_weights, read_config

LAYERS = (Layer.ROAD, Layer.ROUTE, Layer.VEHICLES)
BRIGHTEST, METRES = 255.0, 10.0


@dataclass(frozen=True)
class Options:
    """The options of the learner.

    Attributes:
        width: Channels of the only layer.
        pixels: Of a picture, along each side.
        blind: Whether the image is blank.
    """

    width: int = field(default=4, metadata={"min": 1, "max": 64})
    pixels: int = 32
    blind: bool = False


def pictures(town, options):
    return Rasteriser(town, RasterSpec(options.pixels, 1.0, options.pixels // 4, LAYERS))


def network_of(options):
    side = options.pixels // 4
    return nn.Sequential(
        nn.Conv2d(len(LAYERS), options.width, 5, stride=4, padding=2),
        nn.ReLU(),
        nn.Dropout(0.2),
        nn.Flatten(),
        nn.Linear(options.width * side * side, 8),
        nn.Unflatten(1, (4, 2)),
    )


def blinded(options):
    return replace(options, blind=True)


class PixelLearner(Learner[Options]):
    """Learns from rasters that are drawn for each batch."""

    name = "pixels"
    agent = f"{Path(__file__).resolve()}:Pixels"
    Options = Options
    ablations = MappingProxyType({"sight": (Choice("blind", blinded),)})

    def encode(self, frame):
        picture = pictures(frame.town, self.options).draw(frame.observation)
        return {"picture": picture * (not self.options.blind), "waypoints": frame.waypoints}

    def network(self):
        return network_of(self.options)

    def loss(self, network, batch):
        planned = METRES * network(batch["picture"].float() / BRIGHTEST)
        return {"waypoints": (planned - batch["waypoints"]).abs().mean()}


class Pixels:
    """Drives with the trained network."""

    inputs = frozenset({Input.OBJECTS, Input.ROUTE})

    def __init__(self, folder):
        self.options = read_config(Path(folder), "pixels", TypeAdapter(Options).validate_python)
        self.network = network_of(self.options)
        load_weights(self.network, Path(folder))
        self.network.eval()
        self.files = sorted(Path(folder).glob("*.*"))

    def reset(self, route):
        self.rasteriser = pictures(route.load_town(), self.options)

    def act(self, observation):
        picture = torch.from_numpy(self.rasteriser.draw(observation))[None]
        with torch.inference_mode():
            planned = METRES * self.network(picture.float() / BRIGHTEST)
        return Plan(planned[0].double().numpy().astype(np.float64))
