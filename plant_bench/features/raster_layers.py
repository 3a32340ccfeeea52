"""The layers of a bird's-eye-view raster: contents and drawing functions.

Constants are Roach's (zhejz/carla-roach, carla_gym/core/obs_manager/birdview/chauffeurnet.py).
"""

from collections.abc import Callable
from enum import StrEnum

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageDraw

from plant_bench.agent import Observation, RouteAhead
from plant_bench.features.tokens import TokenSpec, route_attributes
from plant_bench.geometry.box import corners
from plant_bench.geometry.pose import from_frame, to_frame
from plant_bench.world.scene import EGO_EXTENT, EGO_LENGTH, ActorKind, EgoState, Light

ROUTE_VIEW = 80  # m of route drawn (Roach)
ROUTE_WIDTH = 3.2  # m (Roach: 16 pixels at 5 a metre)
STOP_LINE = (1.2, 3.5)  # m along and across the lane (Roach: 6 pixels; lanes are 3.5 m wide)
LIGHT_VALUES = {Light.GREEN: 80, Light.YELLOW: 170, Light.RED: 255}  # Roach
VULNERABLE_SCALE, VULNERABLE_LEAST = 2.0, 1.6  # factor, and minimum size in metres (Roach)
FULL = 255
STANDING, FASTEST = 55, 20.0  # value of stationary vehicles; m/s from which on it is `FULL`

_IS_VULNERABLE = np.array([kind in (ActorKind.PEDESTRIAN, ActorKind.BICYCLE) for kind in ActorKind])


class Layer(StrEnum):
    """The layers and their pixel values; 0 is background."""

    ROAD = "road"  # 255: lanes and junctions
    ROUTE = "route"  # 255: the next 80 m of the route, 3.2 m wide
    ROUTE_BOXES = "route_boxes"  # 255: PlanT's route tokens (PlanCNN)
    LANE_LINES = "lane_lines"  # 255 solid, 120 between lanes of one direction
    EGO = "ego"  # `brightness` of its speed
    VEHICLES = "vehicles"  # 255: vehicles and obstacles
    SPEEDS = "speeds"  # the same boxes, `brightness` of their speeds
    VULNERABLE = "vulnerable"  # 255: pedestrians and riders, drawn twice their size
    LIGHTS = "lights"  # the stop line of the next light: 80 green, 170 yellow, 255 red


def brightness(speed: float) -> int:
    """Return the pixel value of a speed: 55 if stationary, 255 from 20 m/s on.

    >>> brightness(0.0), brightness(10.0), brightness(30.0)
    (55, 155, 255)
    """
    return STANDING + round((FULL - STANDING) * min(max(speed, 0.0) / FASTEST, 1.0))


class Canvas:
    """Draws shapes in world coordinates into images around the ego; mutable.

    Args:
        ego: The ego, which faces the top row.
        size: Pixels along each side.
        scale: Pixels per metre.
        below: Pixels from the ego's centre to the lower edge.
    """

    def __init__(self, ego: EgoState, size: int, scale: float, below: int) -> None:
        self._ego = ego
        self._size, self._scale, self._below = size, scale, below
        self._draw = ImageDraw.Draw(Image.new("L", (1, 1)))

    def picture(
        self, paint: Callable[["Canvas", Observation], None], moment: Observation
    ) -> UInt8[np.ndarray, "size size"]:
        """Return an image drawn by `paint` on a blank canvas."""
        image = Image.new("L", (self._size, self._size))
        self._draw = ImageDraw.Draw(image)
        paint(self, moment)
        return np.asarray(image)

    def line(self, points: Float[np.ndarray, "points 2"], width: float, value: int) -> None:
        """Draw a polyline in world coordinates, `width` metres wide."""
        pixels = self._pixels(to_frame(points, *self._ego.pose)).reshape(-1).tolist()
        thick = max(round(width * self._scale), 1)
        self._draw.line(pixels, fill=value, width=thick, joint="curve")

    def boxes(
        self,
        poses: Float[np.ndarray, "boxes 3"],
        extents: Float[np.ndarray, "boxes 2"],
        values: list[int],
    ) -> None:
        """Draw filled boxes in world coordinates."""
        if not len(poses):
            return
        near = np.hypot(poses[:, 0] - self._ego.x, poses[:, 1] - self._ego.y)
        in_view = np.flatnonzero(near < (1.5 * self._size) / self._scale + 10.0)
        found = corners(poses[in_view].astype(float), extents[in_view].astype(float))
        pixels = self._pixels(to_frame(found.reshape(-1, 2), *self._ego.pose)).reshape(-1, 8)
        for corner, place in zip(pixels.tolist(), in_view.tolist(), strict=True):
            self._draw.polygon(corner, fill=values[place])

    def _pixels(self, points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "points 2"]:
        """Convert ego-frame points to Pillow coordinates: (0, 0) is the first pixel's centre."""
        column = 0.5 * self._size - points[:, 1] * self._scale - 0.5
        row = self._size - self._below - points[:, 0] * self._scale - 0.5
        return np.stack((column, row), axis=1)


def _route(canvas: Canvas, moment: Observation) -> None:
    if moment.route is not None and len(moment.route.points) > 1:
        canvas.line(moment.route.points[: ROUTE_VIEW + 1], ROUTE_WIDTH, FULL)


def _route_boxes(canvas: Canvas, moment: Observation) -> None:
    if moment.route is None:
        return
    ego = moment.ego
    rows = route_attributes(ego, moment.route, TokenSpec())
    places = from_frame(rows[:, 1:3], *ego.pose)
    poses = np.concatenate((places, rows[:, 3:4] + ego.yaw), axis=1)
    canvas.boxes(poses, rows[:, :3:-1], [FULL] * len(rows))


def _ego(canvas: Canvas, moment: Observation) -> None:
    pose, extent = np.array([moment.ego.pose]), np.array([EGO_EXTENT])
    canvas.boxes(pose, extent, [brightness(moment.ego.speed)])


def _vehicles(canvas: Canvas, moment: Observation) -> None:
    _vehicles_as(canvas, moment, by_speed=False)


def _speeds(canvas: Canvas, moment: Observation) -> None:
    _vehicles_as(canvas, moment, by_speed=True)


def _vehicles_as(canvas: Canvas, moment: Observation, *, by_speed: bool) -> None:
    if moment.actors is None:
        return
    shown = moment.actors.only(~_IS_VULNERABLE[moment.actors.kinds])
    speeds = shown.speeds.tolist()
    values = [brightness(speed) if by_speed else FULL for speed in speeds]
    canvas.boxes(shown.poses, shown.extents, values)


def _vulnerable(canvas: Canvas, moment: Observation) -> None:
    if moment.actors is None:
        return
    shown = moment.actors.only(_IS_VULNERABLE[moment.actors.kinds])
    extents = np.maximum(shown.extents * VULNERABLE_SCALE, VULNERABLE_LEAST)
    canvas.boxes(shown.poses, extents, [FULL] * len(shown))


def _lights(canvas: Canvas, moment: Observation) -> None:
    light, route = moment.light, moment.route
    if light is None or route is None or light.state not in LIGHT_VALUES:
        return
    pose = _on_route(route, route.past + 0.5 * EGO_LENGTH + light.distance)
    canvas.boxes(pose, np.array([STOP_LINE]), [LIGHT_VALUES[light.state]])


def _on_route(route: RouteAhead, along: float) -> Float[np.ndarray, "1 3"]:
    """Return the pose of the route `along` metres from its first point."""
    place = min(max(round(along), 0), len(route.points) - 1)
    return np.array([[*route.points[place], route.headings[place]]])


PAINTERS: dict[Layer, Callable[[Canvas, Observation], None]] = {
    Layer.ROUTE: _route,
    Layer.ROUTE_BOXES: _route_boxes,
    Layer.EGO: _ego,
    Layer.VEHICLES: _vehicles,
    Layer.SPEEDS: _speeds,
    Layer.VULNERABLE: _vulnerable,
    Layer.LIGHTS: _lights,
}
