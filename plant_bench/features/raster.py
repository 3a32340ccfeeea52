"""The bird's-eye view: what a planner may see, as layers of pixels around the ego.

The ego heads to the first row; its centre is on the middle column, `below` pixels above the lower
edge. Learned planners on pixels (PlanCNN, AIM-BEV, Roach) and the Gymnasium environment share it.
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

REMEMBERED = frozenset({Layer.VEHICLES, Layer.SPEEDS, Layer.VULNERABLE, Layer.LIGHTS})


@dataclass(frozen=True)
class RasterSpec:
    """What is drawn.

    Attributes:
        size: Pixels along each side.
        scale: Pixels a metre.
        below: Pixels from the ego's centre to the lower edge.
        layers: Channels in order.
        past: Seconds ago, rising to now: layers of what moves (`REMEMBERED`) have one more channel
            for each, before that of now. Early in an episode it is the oldest there is.

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
        """Refuse what cannot be drawn."""
        if self.size < 1 or self.scale <= 0.0 or not 0 <= self.below <= self.size:
            message = (
                f"size {self.size}, scale {self.scale}, below {self.below}: at least one pixel, a "
                "positive scale and an ego inside the picture are wanted."
            )
            raise InputError(message)
        if not self.layers or min(self.past, default=1.0) <= 0.0:
            message = "At least one layer is wanted, and times in the past above 0."
            raise InputError(message)

    @property
    def channels(self) -> tuple[str, ...]:
        """The name of each channel, as in "vehicles" and "vehicles-0.5"."""
        return tuple(
            f"{layer}-{ago:g}" if ago else f"{layer}"
            for layer in self.layers
            for ago in ((*self.past, 0.0) if layer in REMEMBERED else (0.0,))
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
    """Draws observations of one episode; mutable, for what it remembers of the past.

    Args:
        town: Whose roads are drawn.
        spec: What is drawn.
    """

    def __init__(self, town: Town, spec: RasterSpec) -> None:
        self._spec = spec
        self._roads = road_map(town, spec.scale)
        self._seen: deque[Observation] = deque()

    def draw(self, observation: Observation) -> UInt8[np.ndarray, "channels size size"]:
        """Return the next observation as an image; asked in order of time.

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
                shown = moments if layer in REMEMBERED else moments[-1:]
                channels += [canvas.picture(PAINTERS[layer], moment) for moment in shown]
        return np.stack(channels)

    def _remember(self, observation: Observation) -> None:
        longest = max(self._spec.past, default=0.0)
        self._seen.append(observation)
        while len(self._seen) > 1 and observation.time - self._seen[1].time > longest - 1e-6:
            self._seen.popleft()

    def _ago(self, now: Observation, ago: float) -> Observation:
        return min(self._seen, key=lambda then: abs(now.time - ago - then.time))
