"""The driving shared by the expert and the rule-based planner; they differ in the forecast alone.

The acceleration is the least of what the speed limit, the leader, the light, a junction that cannot
be cleared and the forecast conflicts allow; the steering follows the route.
"""

import math
from collections.abc import Callable

import numpy as np

from plant_bench.agent import Control, NextLight, Observation, RouteAhead
from plant_bench.agents.conflicts import ego_poses, first_conflicts, rollout
from plant_bench.agents.control import follow_route, idm, stop_within
from plant_bench.agents.corridor import Corridor, corridor
from plant_bench.agents.forecast import Forecast
from plant_bench.errors import AgentError
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import EGO_LENGTH, EGO_WIDTH, TICK, Actors, EgoState, Light

Forecaster = Callable[[Observation, np.ndarray], Forecast]

INTERVAL = 2  # ticks between two decisions: 10 Hz
CURVE_BRAKING = 1.8  # m/s2 towards a lower speed limit ahead
YELLOW_BRAKING = 3.5  # m/s2 up to which the driver stops for a yellow light
CHOICES = np.array([0.5, 0.0, -1.0, -2.0, -3.5, -5.0, -8.0])  # m/s2 tried when the first fails
LINE_BRAKING = 4.5  # m/s2 up to which a conflict in a junction is answered at its stop line
SLOW_LEADER = 3.0  # m/s below which a leader may block a junction
ROOM_BEYOND = 1.5  # m kept free behind the ego when it has cleared a junction
PATIENCE = 8.0  # s of waiting after which the margins towards who stands begin to shrink
SHRINKING = 20.0  # s of further waiting until they are gone
HALF = 0.5 * EGO_LENGTH


class CarefulDriver:
    """Follows the route and keeps clear of what it forecasts; mutable.

    Args:
        forecaster: Tells where others will be.
    """

    def __init__(self, forecaster: Forecaster) -> None:
        self._forecaster = forecaster
        self._passages: tuple[Passage, ...] = ()
        self._waited = 0.0

    def reset(self, route: Route | None) -> None:
        """Start a new episode.

        Raises:
            AgentError: No route was given.
        """
        if route is None:
            message = "This driver needs the input 'route'."
            raise AgentError(message)
        self._passages = route.passages
        self._waited = 0.0

    def act(self, observation: Observation) -> Control:
        """Decide.

        Raises:
            AgentError: An input is missing.
        """
        route = observation.route
        if route is None or observation.actors is None:
            message = "This driver needs the inputs 'objects' and 'route'."
            raise AgentError(message)
        pull = self._decide(observation, route, observation.actors)
        return Control(pull, follow_route(observation.ego, route))

    def _decide(self, observation: Observation, route: RouteAhead, actors: Actors) -> float:
        ego = observation.ego
        target = allowed_speed(route)
        pull = min(idm(ego.speed, target), light_limit(ego.speed, observation.light))
        if not len(actors):
            return pull
        ahead = corridor(route, actors, route.past, ego.speed)
        leader = ahead.leader()
        pull = min(pull, idm(ego.speed, target, leader.distance - HALF, leader.speed))
        pull = min(pull, self._clear_junction(ego, route.progress, ahead))
        return self._avoid(observation, route, ahead, pull, target)

    def _clear_junction(self, ego: EgoState, progress: float, ahead: Corridor) -> float:
        """Wait before a junction when there is no room behind the queue beyond it."""
        passage = self._next_passage(progress)
        if passage is None:
            return math.inf
        distance = passage.entry - progress - HALF
        if distance > 30.0 or distance < -1.0:
            return math.inf
        needed = passage.exit - progress + EGO_LENGTH + ROOM_BEYOND
        blocking = ahead.inside & ~ahead.crossing & (ahead.speeds < SLOW_LEADER)
        # A slow leader is expected to go on for two seconds as it drives now.
        place = ahead.nearest + 2.0 * ahead.speeds
        blocking &= (place < needed) & (ahead.nearest > distance + HALF - 1.0)
        if not blocking.any():
            return math.inf
        return stop_within(ego.speed, max(distance, 0.1))

    def _next_passage(self, progress: float) -> Passage | None:
        front = progress + HALF
        return next((item for item in self._passages if item.entry > front - 1.0), None)

    def _avoid(
        self,
        observation: Observation,
        route: RouteAhead,
        ahead: Corridor,
        pull: float,
        target: float,
    ) -> float:
        """Return the greatest acceleration up to `pull` that meets no forecast box."""
        ego, actors = observation.ego, observation.actors
        if actors is None:
            return pull
        keep = np.flatnonzero(_may_conflict(ego, actors, ahead))
        if not keep.size:
            self._waited = 0.0
            return pull
        boldness = min(max((self._waited - PATIENCE) / SHRINKING, 0.0), 1.0)
        forecast = self._forecaster(observation, keep)
        first = np.array([pull])
        travel = rollout(ego.speed, first, np.array([target]))
        times = first_conflicts(ego_poses(route, route.past, travel), forecast, boldness)
        if times[0] == math.inf:
            self._waited = 0.0
            return pull
        self._waited = self._waited + INTERVAL * TICK if ego.speed < 0.5 else 0.0
        choices = np.concatenate((first, CHOICES[pull > CHOICES]))
        travel = rollout(ego.speed, choices, np.full(len(choices), target))
        poses = ego_poses(route, route.past, travel)
        times = first_conflicts(poses, forecast, boldness)
        if times.max() == 0.0:  # within the margins already: what matters is not to touch
            times = first_conflicts(poses, forecast, boldness, caution=0.0)
        # The first that is clear, else the one that is clear longest, else the hardest braking.
        best = (
            int(np.argmax(times))
            if times.max() > times.min() or times[0] == math.inf
            else len(times) - 1
        )
        return self._at_the_line(ego, route.progress, float(choices[best]), travel[best])

    def _at_the_line(
        self, ego: EgoState, progress: float, pull: float, travel: np.ndarray
    ) -> float:
        """Rather stop at a junction's line than inside it."""
        passage = self._next_passage(progress)
        if passage is None:
            return pull
        distance = passage.entry - progress - HALF
        reached = progress + HALF + travel[-1]
        stops = travel[-1] - travel[-2] < 0.3
        inside = passage.entry < reached < passage.exit + EGO_LENGTH
        needed = ego.speed**2 / (2.0 * max(distance, 0.1))
        if stops and inside and distance > -0.5 and needed < LINE_BRAKING:
            return min(pull, stop_within(ego.speed, max(distance, 0.1)))
        return pull


def allowed_speed(route: RouteAhead) -> float:
    """Return the speed from which all limits ahead are met with comfortable braking."""
    distance = np.maximum(np.arange(len(route.speed_limits)) - 1.0, 0.0)
    return float(np.sqrt(np.min(route.speed_limits**2 + 2.0 * CURVE_BRAKING * distance)))


def light_limit(speed: float, light: NextLight | None) -> float:
    """Return the acceleration that a traffic light allows."""
    if light is None or light.state in (Light.GREEN, Light.UNKNOWN):
        return math.inf
    if light.distance < -1.0:
        return math.inf
    distance = max(light.distance, 0.1)
    needed = speed * speed / (2.0 * distance)
    if light.state is Light.YELLOW and needed > YELLOW_BRAKING:
        return math.inf
    return stop_within(speed, distance)


def _may_conflict(ego: EgoState, actors: Actors, ahead: Corridor) -> np.ndarray:
    """Tell which actors a forecast is needed for: not the leader's queue, not who follows."""
    cos, sin = math.cos(ego.yaw), math.sin(ego.yaw)
    dx, dy = actors.poses[:, 0] - ego.x, actors.poses[:, 1] - ego.y
    forward, left = cos * dx + sin * dy, cos * dy - sin * dx
    aligned = np.cos(actors.poses[:, 2] - ego.yaw) > 0.8
    follows = (forward < -HALF) & (np.abs(left) < 0.5 * EGO_WIDTH + 0.5) & aligned
    leads = ahead.inside & ~ahead.crossing
    reach = 20.0 + 5.0 * (ego.speed + actors.speeds)
    return ~follows & ~leads & (dx * dx + dy * dy < reach * reach)
