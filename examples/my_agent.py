"""A complete planner: follows its route, and stops for red lights and for the vehicle ahead.

plant-bench score --agent examples/my_agent.py:MyAgent --routes 0 --repetitions 1
"""

import numpy as np

from plant_bench.agent import Control, Input, Observation
from plant_bench.world.route import Route
from plant_bench.world.scene import Light

LOOK_AHEAD = 6  # m along the route to steer for
WHEELBASE = 2.9  # m
GAP = 8.0  # m between the centres of the ego and the vehicle ahead


class MyAgent:
    """Steers for a point on the route; its speed is what it could still stop from."""

    inputs = frozenset({Input.ROUTE, Input.OBJECTS, Input.LIGHT})

    def reset(self, route: Route | None) -> None:
        """Start a new episode; there is nothing to forget."""

    def act(self, observation: Observation) -> Control:
        """Decide, 20 times a second."""
        ego, route, light = observation.ego, observation.route, observation.light
        free = 50.0
        if light is not None and light.state is not Light.GREEN:
            free = max(light.distance - 1.0, 0.0)
        if observation.actors is not None:
            offsets = observation.actors.poses[:, :2] - (ego.x, ego.y)
            ahead = offsets @ (np.cos(ego.yaw), np.sin(ego.yaw))
            aside = np.abs(offsets @ (-np.sin(ego.yaw), np.cos(ego.yaw)))
            free = min([free, *(ahead[(ahead > 0.0) & (aside < 2.0)] - GAP)])
        wanted = min(observation.speed_limit, np.sqrt(4.0 * max(free, 0.0)))
        if route is None:
            return Control(-3.0, 0.0)
        dx, dy = route.points[min(LOOK_AHEAD, len(route.points) - 1)] - (ego.x, ego.y)
        bearing = np.arctan2(dy, dx) - ego.yaw
        steering = np.arctan2(2.0 * WHEELBASE * np.sin(bearing), np.hypot(dx, dy))
        return Control(float(np.clip(wanted - ego.speed, -6.0, 2.0)), float(steering))
