"""The bird's-eye view: what a planner may see, as layers of pixels around the ego.

The ego heads to the first row; its centre is on the middle column, `below` pixels above the lower
edge. Learned planners on pixels (PlanCNN, AIM-BEV, Roach) and the Gymnasium environment share it.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageDraw

from plant_bench.agent import Observation, RouteAhead
from plant_bench.errors import AgentError, InputError
from plant_bench.features.roads import LINE_VALUES, ROAD_VALUES, RoadMap, road_map
from plant_bench.features.tokens import TokenSpec, route_attributes
from plant_bench.geometry.box import corners
from plant_bench.geometry.pose import to_frame
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, ActorKind, EgoState, Light
from plant_bench.world.town import Town

ROUTE_VIEW = 80  # m of route drawn (Roach)
ROUTE_WIDTH = 3.2  # m (Roach: 16 pixels at 5 a metre)
STOP_LINE = (1.2, 3.5)  # m along and across the lane (Roach: 6 pixels thick; a lane is 3.5 m wide)
LIGHT_VALUES = {Light.GREEN: 80, Light.YELLOW: 170, Light.RED: 255}  # Roach
VULNERABLE_SCALE, VULNERABLE_LEAST = 2.0, 1.6  # times, and m at least: people are small (Roach)
FULL = 255
STANDING, FASTEST = 55, 20.0  # the value of who stands; m/s from which on it is `FULL`

_IS_VULNERABLE = np.array([kind in (ActorKind.PEDESTRIAN, ActorKind.BICYCLE) for kind in ActorKind])


class Layer(StrEnum):
    """What a channel shows; 0 where there is nothing of it."""

    ROAD = "road"  # 255: lanes and junctions
    ROUTE = "route"  # 255: the next 80 m of the route, 3.2 m wide
    ROUTE_BOXES = "route_boxes"  # 255: PlanT's route tokens (PlanCNN)
    LANE_LINES = "lane_lines"  # 255 solid, 120 between lanes of one direction
    EGO = "ego"  # `brightness` of its speed
    VEHICLES = "vehicles"  # 255: vehicles and obstacles
    SPEEDS = "speeds"  # the same boxes, `brightness` of their speeds
    VULNERABLE = "vulnerable"  # 255: pedestrians and riders, drawn twice their size
    LIGHTS = "lights"  # the stop line of the next light: 80 green, 170 yellow, 255 red


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


def brightness(speed: float) -> int:
    """Return the value that tells a speed: 55 for who stands, 255 from 20 m/s on.

    >>> brightness(0.0), brightness(10.0), brightness(30.0)
    (55, 155, 255)
    """
    return STANDING + round((FULL - STANDING) * min(max(speed, 0.0) / FASTEST, 1.0))


class Rasteriser:
    """Draws observations of one episode; mutable, for what it remembers of the past.

    Args:
        town: Whose roads are drawn.
        spec: What is drawn.
    """

    def __init__(self, town: Town, spec: RasterSpec) -> None:
        self._spec = spec
        self._roads: RoadMap = road_map(town, spec.scale)
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
        moments = [*(self._ago(observation, ago) for ago in self._spec.past), observation]
        canvas = _Canvas(observation.ego, self._spec)
        codes = self._roads.window(observation.ego, self._spec.size, self._spec.below)
        channels = []
        for layer in self._spec.layers:
            if layer is Layer.ROAD:
                channels.append(ROAD_VALUES[codes])
            elif layer is Layer.LANE_LINES:
                channels.append(LINE_VALUES[codes])
            else:
                shown = moments if layer in REMEMBERED else moments[-1:]
                channels += [canvas.picture(_PAINTERS[layer], moment) for moment in shown]
        return np.stack(channels)

    def _remember(self, observation: Observation) -> None:
        longest = max(self._spec.past, default=0.0)
        self._seen.append(observation)
        while len(self._seen) > 1 and observation.time - self._seen[1].time > longest - 1e-6:
            self._seen.popleft()

    def _ago(self, now: Observation, ago: float) -> Observation:
        return min(self._seen, key=lambda then: abs(now.time - ago - then.time))


class _Canvas:
    """Draws what is given in the world, or in the frame of an ego, into pictures of one view."""

    def __init__(self, ego: EgoState, spec: RasterSpec) -> None:
        self._ego = ego
        self._spec = spec
        self._draw = ImageDraw.Draw(Image.new("L", (1, 1)))

    def picture(
        self, paint: Callable[["_Canvas", Observation], None], moment: Observation
    ) -> UInt8[np.ndarray, "size size"]:
        """Return an empty picture after somebody has painted on it."""
        image = Image.new("L", (self._spec.size, self._spec.size))
        self._draw = ImageDraw.Draw(image)
        paint(self, moment)
        return np.asarray(image)

    def line(self, points: Float[np.ndarray, "points 2"], width: float, value: int) -> None:
        """Draw a line of the world, `width` metres wide."""
        pixels = self._pixels(to_frame(points, *self._ego.pose)).reshape(-1).tolist()
        thick = max(round(width * self._spec.scale), 1)
        self._draw.line(pixels, fill=value, width=thick, joint="curve")

    def boxes(
        self,
        poses: Float[np.ndarray, "boxes 3"],
        extents: Float[np.ndarray, "boxes 2"],
        values: list[int],
    ) -> None:
        """Draw boxes of the world."""
        if not len(poses):
            return
        spec = self._spec
        near = np.hypot(poses[:, 0] - self._ego.x, poses[:, 1] - self._ego.y)
        in_view = np.flatnonzero(near < (1.5 * spec.size) / spec.scale + 10.0)
        found = corners(poses[in_view].astype(float), extents[in_view].astype(float))
        pixels = self._pixels(to_frame(found.reshape(-1, 2), *self._ego.pose)).reshape(-1, 8)
        for corner, place in zip(pixels.tolist(), in_view.tolist(), strict=True):
            self._draw.polygon(corner, fill=values[place])

    def _pixels(self, points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "points 2"]:
        """Return places in the ego frame as Pillow counts them: from the first pixel's centre."""
        spec = self._spec
        column = 0.5 * spec.size - points[:, 1] * spec.scale - 0.5
        row = spec.size - spec.below - points[:, 0] * spec.scale - 0.5
        return np.stack((column, row), axis=1)


def _route(canvas: _Canvas, moment: Observation) -> None:
    if moment.route is not None and len(moment.route.points) > 1:
        canvas.line(moment.route.points[: ROUTE_VIEW + 1], ROUTE_WIDTH, FULL)


def _route_boxes(canvas: _Canvas, moment: Observation) -> None:
    if moment.route is None:
        return
    ego = moment.ego
    rows = route_attributes(ego, moment.route, TokenSpec())
    poses = rows[:, 1:4].copy()
    cos, sin = np.cos(ego.yaw), np.sin(ego.yaw)
    poses[:, 0] = ego.x + cos * rows[:, 1] - sin * rows[:, 2]
    poses[:, 1] = ego.y + sin * rows[:, 1] + cos * rows[:, 2]
    poses[:, 2] += ego.yaw
    canvas.boxes(poses, rows[:, :3:-1], [FULL] * len(rows))


def _ego(canvas: _Canvas, moment: Observation) -> None:
    pose, extent = np.array([moment.ego.pose]), np.array([EGO_EXTENT])
    canvas.boxes(pose, extent, [brightness(moment.ego.speed)])


def _vehicles(canvas: _Canvas, moment: Observation) -> None:
    _vehicles_as(canvas, moment, tell_speed=False)


def _speeds(canvas: _Canvas, moment: Observation) -> None:
    _vehicles_as(canvas, moment, tell_speed=True)


def _vehicles_as(canvas: _Canvas, moment: Observation, *, tell_speed: bool) -> None:
    if moment.actors is None:
        return
    shown = moment.actors.only(~_IS_VULNERABLE[moment.actors.kinds])
    speeds = shown.speeds.tolist()
    values = [brightness(speed) if tell_speed else FULL for speed in speeds]
    canvas.boxes(shown.poses, shown.extents, values)


def _vulnerable(canvas: _Canvas, moment: Observation) -> None:
    if moment.actors is None:
        return
    shown = moment.actors.only(_IS_VULNERABLE[moment.actors.kinds])
    extents = np.maximum(shown.extents * VULNERABLE_SCALE, VULNERABLE_LEAST)
    canvas.boxes(shown.poses, extents, [FULL] * len(shown))


def _lights(canvas: _Canvas, moment: Observation) -> None:
    light, route = moment.light, moment.route
    if light is None or route is None or light.state not in LIGHT_VALUES:
        return
    pose = _on_route(route, route.past + 0.5 * EGO_LENGTH + light.distance)
    canvas.boxes(pose, np.array([STOP_LINE]), [LIGHT_VALUES[light.state]])


def _on_route(route: RouteAhead, along: float) -> Float[np.ndarray, "1 3"]:
    """Return the pose of the route `along` metres from its first point."""
    place = min(max(round(along), 0), len(route.points) - 1)
    return np.array([[*route.points[place], route.headings[place]]])


_PAINTERS: dict[Layer, Callable[[_Canvas, Observation], None]] = {
    Layer.ROUTE: _route,
    Layer.ROUTE_BOXES: _route_boxes,
    Layer.EGO: _ego,
    Layer.VEHICLES: _vehicles,
    Layer.SPEEDS: _speeds,
    Layer.VULNERABLE: _vulnerable,
    Layer.LIGHTS: _lights,
}
