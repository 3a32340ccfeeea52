"""Observations as arrays of a fixed size. Nothing privileged: each sees what a planner is given."""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from gymnasium import spaces
from jaxtyping import Float, UInt8

from plant_bench.agent import LIGHT_RANGE, ROUTE_AHEAD, Observation
from plant_bench.errors import InputError
from plant_bench.features.inputs import scene_input
from plant_bench.features.raster import Rasteriser, RasterSpec
from plant_bench.features.tokens import TokenKind, Tokens, TokenSpec
from plant_bench.features.tracks import Tracks
from plant_bench.geometry.pose import to_frame, wrap_angles
from plant_bench.sim.ego import ACCELERATION_LIMIT, BRAKING_LIMIT, STEERING_LIMIT
from plant_bench.sim.traffic import SIGHT
from plant_bench.world.scene import EGO_LENGTH, ActorKind, Light
from plant_bench.world.town import Town

MOST_ACTORS = 48  # the nearest; dense traffic shows about 30 within 80 m
FASTEST = 60.0  # m/s, beyond any speed limit
LONGEST = 30.0  # m, beyond any vehicle
ROUTE_REACH = float(ROUTE_AHEAD + 40)  # m: the ego may be 30 m beside the route

# Walkers and the lines of lights are told; meetings and tracks, which follow from boxes, are not.
PLAIN_TOKENS = TokenSpec(vulnerable=True, stop_line=True)


@runtime_checkable
class Encoder(Protocol):
    """Turns what is seen into arrays; may remember the episode.

    Attributes:
        space: What `encode` returns is in it.
    """

    space: spaces.Space

    def reset(self, town: Town) -> None:
        """Start a new episode in a town."""
        ...

    def encode(self, observation: Observation) -> Any:
        """Return new arrays for the next observation."""
        ...


class TokenEncoder:
    """What PlanT is told: object tokens, filled up with zeros, and the few facts beside them.

    Args:
        spec: What becomes a token.
        most: Rows; actors come nearest first, and those that do not fit are left out.

    Raises:
        InputError: There are fewer rows than route segments and a stop line need.
    """

    def __init__(self, spec: TokenSpec = PLAIN_TOKENS, most: int = 40) -> None:
        if most <= spec.segments + 1:
            message = f"{most} tokens: more than {spec.segments + 1} are wanted."
            raise InputError(message)
        self._spec, self._most = spec, most
        self._tracks = Tracks()
        reach = ROUTE_REACH + FASTEST * spec.foresight
        self.space = spaces.Dict(
            {
                "tokens": spaces.Box(-reach, reach, (most, spec.attributes), np.float32),
                "kinds": spaces.Box(0, max(TokenKind), (most,), np.uint8),
                "mask": spaces.MultiBinary(most),
                "red": _box(0.0, 1.0, 1),
                "target": _box(-ROUTE_REACH, ROUTE_REACH, 2),
                "speed": _box(0.0, FASTEST, 1),
                "limit": _box(0.0, FASTEST, 1),
            }
        )

    def reset(self, town: Town) -> None:
        """Forget who was where."""
        del town
        self._tracks.forget()

    def encode(self, observation: Observation) -> dict[str, np.ndarray]:
        """Return `SceneInput` as arrays."""
        rates = None
        if self._spec.tracks and observation.actors is not None:
            rates = self._tracks.rates(observation.time, observation.actors)
        given = scene_input(observation, self._spec, rates)
        attributes, kinds = self._fitting(given.tokens)
        count = len(kinds)
        tokens = np.zeros((self._most, self._spec.attributes), np.float32)
        tokens[:count] = attributes
        all_kinds = np.full(self._most, TokenKind.PADDING, np.uint8)
        all_kinds[:count] = kinds
        mask = np.zeros(self._most, np.int8)
        mask[:count] = 1
        return _in_bounds(
            self.space,
            {
                "tokens": tokens,
                "kinds": all_kinds,
                "mask": mask,
                "red": np.array([given.red], np.float32),
                "target": np.array(given.target, np.float32),
                "speed": np.array([given.speed], np.float32),
                "limit": np.array([given.limit], np.float32),
            },
        )

    def _fitting(
        self, tokens: Tokens
    ) -> tuple[Float[np.ndarray, "tokens attributes"], UInt8[np.ndarray, " tokens"]]:
        """Return the tokens without the farthest actors that do not fit; the rest always does."""
        surplus = max(len(tokens) - self._most, 0)
        actors = int(np.count_nonzero(tokens.places >= 0))
        keep = np.ones(len(tokens), bool)
        keep[actors - surplus : actors] = False
        return tokens.attributes[keep], tokens.kinds[keep]


class ObjectEncoder:
    """The observation itself as arrays in the ego frame.

    Args:
        most: Actors, the nearest first; those that do not fit are left out.
    """

    def __init__(self, most: int = MOST_ACTORS) -> None:
        self._most = most
        low = np.array([-SIGHT, -SIGHT, -np.pi, 0.0, 0.0, 0.0], np.float32)
        high = np.array([SIGHT, SIGHT, np.pi, FASTEST, LONGEST, LONGEST], np.float32)
        route = np.array([ROUTE_REACH, ROUTE_REACH, np.pi, FASTEST], np.float32)
        ego = np.array([FASTEST, ACCELERATION_LIMIT, STEERING_LIMIT], np.float32)
        rows, points = (most, 1), (ROUTE_AHEAD + 1, 1)
        self.space = spaces.Dict(
            {
                "ego": spaces.Box(np.array([0.0, -BRAKING_LIMIT, -ego[2]], np.float32), ego),
                "actors": spaces.Box(np.tile(low, rows), np.tile(high, rows)),
                "kinds": spaces.Box(0, max(ActorKind), (most,), np.uint8),
                "mask": spaces.MultiBinary(most),
                "route": spaces.Box(np.tile(-route, points), np.tile(route, points)),
                "route_mask": spaces.MultiBinary(ROUTE_AHEAD + 1),
                "offset": _box(-ROUTE_REACH, ROUTE_REACH, 1),
                "light": spaces.Discrete(len(Light)),
                "light_distance": _box(-EGO_LENGTH, LIGHT_RANGE, 1),
                "speed_limit": _box(0.0, FASTEST, 1),
            }
        )

    def reset(self, town: Town) -> None:
        """There is nothing to forget."""

    def encode(self, observation: Observation) -> dict[str, Any]:
        """Return the observation as arrays; rows that hold nothing are 0, and so is their mask."""
        ego, light = observation.ego, observation.light
        actors, kinds, mask = self._actors(observation)
        route, route_mask = _route(observation)
        offset = 0.0 if observation.route is None else observation.route.offset
        distance = LIGHT_RANGE if light is None else light.distance
        return _in_bounds(
            self.space,
            {
                "ego": np.array([ego.speed, ego.acceleration, ego.steering], np.float32),
                "actors": actors,
                "kinds": kinds,
                "mask": mask,
                "route": route,
                "route_mask": route_mask,
                "offset": np.array([offset], np.float32),
                "light": np.int64(Light.UNKNOWN if light is None else light.state),
                "light_distance": np.array([distance], np.float32),
                "speed_limit": np.array([observation.speed_limit], np.float32),
            },
        )

    def _actors(self, observation: Observation) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        rows = np.zeros((self._most, 6), np.float32)
        kinds = np.zeros(self._most, np.uint8)
        mask = np.zeros(self._most, np.int8)
        ego, actors = observation.ego, observation.actors
        if actors is None:
            return rows, kinds, mask
        away = np.hypot(actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y)
        shown = actors.only(away.argsort(kind="stable")[: self._most])
        count = len(shown)
        rows[:count, :2] = to_frame(shown.poses[:, :2].astype(float), *ego.pose)
        rows[:count, 2] = wrap_angles(shown.poses[:, 2].astype(float) - ego.yaw)
        rows[:count, 3] = shown.speeds
        rows[:count, 4:] = shown.extents
        kinds[:count] = shown.kinds
        mask[:count] = 1
        return rows, kinds, mask


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


def encoder_of(wanted: str | Encoder) -> Encoder:
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
    return wanted


def _box(low: float, high: float, size: int) -> spaces.Box:
    return spaces.Box(low, high, (size,), np.float32)


def _route(observation: Observation) -> tuple[np.ndarray, np.ndarray]:
    """Return x, y, heading and speed limit of the route's points in the ego frame, and a mask."""
    rows = np.zeros((ROUTE_AHEAD + 1, 4), np.float32)
    mask = np.zeros(ROUTE_AHEAD + 1, np.int8)
    route, ego = observation.route, observation.ego
    if route is not None:
        count = len(route.points)
        rows[:count, :2] = to_frame(route.points, *ego.pose)
        rows[:count, 2] = wrap_angles(route.headings - ego.yaw)
        rows[:count, 3] = route.speed_limits
        mask[:count] = 1
    return rows, mask


def _in_bounds(space: spaces.Dict, values: dict[str, Any]) -> dict[str, Any]:
    """Return the values with what lies beyond the bounds of a box cut off."""
    boxes = {name: box for name, box in space.items() if isinstance(box, spaces.Box)}
    return {
        name: np.clip(value, boxes[name].low, boxes[name].high) if name in boxes else value
        for name, value in values.items()
    }
