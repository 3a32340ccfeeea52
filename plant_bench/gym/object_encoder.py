"""Encodes actors, route, light and ego as fixed-size arrays in the ego frame."""

from typing import Any

import numpy as np
from gymnasium import spaces

from plant_bench.agent import LIGHT_RANGE, ROUTE_AHEAD, Observation
from plant_bench.geometry.pose import to_frame, wrap_angles
from plant_bench.gym.observation_bounds import FASTEST, LONGEST, ROUTE_REACH, box, in_bounds
from plant_bench.sim.ego import ACCELERATION_LIMIT, BRAKING_LIMIT, STEERING_LIMIT
from plant_bench.sim.traffic import SIGHT
from plant_bench.world.scene import EGO_LENGTH, ActorKind, Light
from plant_bench.world.town import Town

MOST_ACTORS = 48


class ObjectEncoder:
    """The observation itself as arrays in the ego frame.

    Args:
        most: Maximum number of actors; the nearest ones are kept.
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
                "offset": box(-ROUTE_REACH, ROUTE_REACH, 1),
                "light": spaces.Discrete(len(Light)),
                "light_distance": box(-EGO_LENGTH, LIGHT_RANGE, 1),
                "speed_limit": box(0.0, FASTEST, 1),
            }
        )

    def reset(self, town: Town) -> None:
        """Start a new episode; there is no state to clear."""

    def encode(self, observation: Observation) -> dict[str, Any]:
        """Return the observation as arrays; unused rows and their mask are 0."""
        ego, light = observation.ego, observation.light
        actors, kinds, mask = self._actors(observation)
        route, route_mask = _route(observation)
        offset = 0.0 if observation.route is None else observation.route.offset
        distance = LIGHT_RANGE if light is None else light.distance
        return in_bounds(
            self.space.spaces,
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
        distances = np.hypot(actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y)
        nearest = actors.only(distances.argsort(kind="stable")[: self._most])
        count = len(nearest)
        rows[:count, :2] = to_frame(nearest.poses[:, :2].astype(float), *ego.pose)
        rows[:count, 2] = wrap_angles(nearest.poses[:, 2].astype(float) - ego.yaw)
        rows[:count, 3] = nearest.speeds
        rows[:count, 4:] = nearest.extents
        kinds[:count] = nearest.kinds
        mask[:count] = 1
        return rows, kinds, mask


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
