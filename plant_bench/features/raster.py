"""Bird's-eye-view rasters: observations as image channels around the ego.

The ego faces the top row; its centre is on the middle column, `below` pixels above the lower edge.
For planners with raster inputs (PlanCNN, AIM-BEV, Roach) and the Gymnasium environment.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from plant_bench.agent import Observation
from plant_bench.errors import AgentError, InputError
from plant_bench.features.raster_layers import PAINTERS, Canvas, Layer
from plant_bench.features.road_raster import LINE_VALUES, ROAD_VALUES, road_map
from plant_bench.world.town import Town

DYNAMIC = frozenset({Layer.VEHICLES, Layer.SPEEDS, Layer.VULNERABLE, Layer.LIGHTS})


@dataclass(frozen=True)
class RasterSpec:
    """Size, scale and channels of a raster.

    Attributes:
        size: Pixels along each side.
        scale: Pixels per metre.
        below: Pixels from the ego's centre to the lower edge.
        layers: The layers, in order.
        past: Ages of past frames in seconds, in descending order. Layers of moving objects
            (`DYNAMIC`) have one more channel for each, before the present one. Early in an episode
            the oldest frame replaces missing ones.

    Raises:
        InputError: A value is out of range.
    """

    size: int = 192
    scale: float = 5.0
    below: int = 40
    layers: tuple[Layer, ...] = (
        Layer.ROAD,
        Layer.ROUTE,
        Layer.LANE_LINES,
        Layer.EGO,
        Layer.VEHICLES,
        Layer.SPEEDS,
        Layer.VULNERABLE,
        Layer.LIGHTS,
    )
    past: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check the values."""
        if self.size < 1 or self.scale <= 0.0 or not 0 <= self.below <= self.size:
            message = (
                "Expected a size of at least one pixel, a positive scale and 0 <= below <= size, "
                f"got size {self.size}, scale {self.scale}, below {self.below}."
            )
            raise InputError(message)
        if not self.layers or min(self.past, default=1.0) <= 0.0:
            message = "Expected at least one layer, and ages of past frames above 0."
            raise InputError(message)

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels' names, such as "vehicles" and "vehicles-0.5"."""
        return tuple(
            f"{layer}-{ago:g}" if ago else f"{layer}"
            for layer in self.layers
            for ago in ((*self.past, 0.0) if layer in DYNAMIC else (0.0,))
        )


# zhejz/carla-roach, config/agent/ppo/obs_configs: 15 channels, history of 16, 11, 6 and 1 frames
# at 10 Hz, the latest being now.
ROACH = RasterSpec(
    layers=(
        Layer.ROAD,
        Layer.ROUTE,
        Layer.LANE_LINES,
        Layer.VEHICLES,
        Layer.VULNERABLE,
        Layer.LIGHTS,
    ),
    past=(1.5, 1.0, 0.5),
)


class Rasteriser:
    """Draws the observations of one episode; mutable, since it keeps past frames.

    Args:
        town: The town whose roads are drawn.
        spec: Size, scale and channels.
    """

    def __init__(self, town: Town, spec: RasterSpec) -> None:
        self._spec = spec
        self._roads = road_map(town, spec.scale)
        self._history: deque[Observation] = deque()

    def draw(self, observation: Observation) -> UInt8[np.ndarray, "channels size size"]:
        """Return the raster of an observation; call it in order of time.

        Raises:
            AgentError: The observation lacks objects or route.
        """
        if observation.actors is None or observation.route is None:
            message = "A bird's-eye view needs the inputs 'objects' and 'route'."
            raise AgentError(message)
        self._remember(observation)
        spec, ego = self._spec, observation.ego
        moments = [*(self._ago(observation, ago) for ago in spec.past), observation]
        canvas = Canvas(ego, spec.size, spec.scale, spec.below)
        codes = self._roads.window(ego, spec.size, spec.below)
        channels = []
        for layer in spec.layers:
            if layer is Layer.ROAD:
                channels.append(ROAD_VALUES[codes])
            elif layer is Layer.LANE_LINES:
                channels.append(LINE_VALUES[codes])
            else:
                shown = moments if layer in DYNAMIC else moments[-1:]
                channels += [canvas.picture(PAINTERS[layer], moment) for moment in shown]
        return np.stack(channels)

    def _remember(self, observation: Observation) -> None:
        longest = max(self._spec.past, default=0.0)
        self._history.append(observation)
        while len(self._history) > 1 and observation.time - self._history[1].time > longest - 1e-6:
            self._history.popleft()

    def _ago(self, now: Observation, ago: float) -> Observation:
        return min(self._history, key=lambda then: abs(now.time - ago - then.time))
