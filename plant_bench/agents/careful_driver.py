"""The driving shared by the expert and the rule-based planner; they differ in the forecast alone.

The acceleration is the least of what the speed limit, the leader, the light, a junction that cannot
be cleared and the forecast conflicts allow; the steering follows the route.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from plant_bench.agent import (
    NOBODY,
    Cause,
    Control,
    NextLight,
    Observation,
    Reason,
    RouteAhead,
)
from plant_bench.agents.conflicts import clearest, ego_poses, first_conflicts, rollout
from plant_bench.agents.control import follow_route, idm, stop_within
from plant_bench.agents.corridor import Corridor, corridor
from plant_bench.agents.forecast import STEP, Forecast
from plant_bench.agents.neighbours import left_behind, may_conflict
from plant_bench.errors import AgentError
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import (
    EGO_LENGTH,
    TICK,
    ActorKind,
    Actors,
    EgoState,
    Light,
)

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
CREEPING = 3.0  # m/s below which a junction is not left in good time
NOTICEABLE = 0.1  # m/s2 that somebody must cost to be a reason
HALF = 0.5 * EGO_LENGTH


class Demand(NamedTuple):
    """What one rule of driving asks for.

    Attributes:
        pull: The greatest acceleration it allows, m/s2.
        cause: Which rule.
        actor: The id of whom it is about.
    """

    pull: float
    cause: Cause
    actor: int = NOBODY


class CarefulDriver:
    """Follows the route and keeps clear of what it forecasts; mutable.

    Args:
        forecaster: Tells where others will be.
    """

    def __init__(self, forecaster: Forecaster) -> None:
        self._forecaster = forecaster
        self._passages: tuple[Passage, ...] = ()
        self._waited = 0.0
        self._reason = Reason(Cause.FREE)

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
        self._reason = Reason(Cause.FREE)

    def act(self, observation: Observation) -> Control:
        """Decide.

        Raises:
            AgentError: An input is missing.
        """
        route = observation.route
        if route is None or observation.actors is None:
            message = "This driver needs the inputs 'objects' and 'route'."
            raise AgentError(message)
        ego, actors = observation.ego, observation.actors
        if (behind := left_behind(ego, actors)).any():
            observation = observation.showing(~behind)
        target = allowed_speed(route)
        free = Demand(idm(ego.speed, target), Cause.LIMIT)
        least = self._decide(observation, route, free, target)
        self._reason = _reason(least, free)
        return Control(least.pull, follow_route(observation.ego, route))

    def explain(self) -> Reason:
        """Return what decided the last acceleration: the single demand that was the least."""
        return self._reason

    def _decide(
        self, observation: Observation, route: RouteAhead, free: Demand, target: float
    ) -> Demand:
        ego, actors = observation.ego, observation.actors
        least = min(free, Demand(light_limit(ego.speed, observation.light), Cause.LIGHT))
        if actors is None or not len(actors):
            return least
        ahead = corridor(route, actors, route.past, ego.speed)
        least = min(least, self._follow(ego, target, actors, ahead))
        least = min(least, self._clear_junction(ego, route.progress, actors, ahead))
        return self._avoid(observation, route, ahead, least, target)

    def _follow(self, ego: EgoState, target: float, actors: Actors, ahead: Corridor) -> Demand:
        leader = ahead.leader()
        pull = idm(ego.speed, target, leader.distance - HALF, leader.speed)
        who = NOBODY if leader.actor < 0 else int(actors.ids[leader.actor])
        return Demand(pull, Cause.LEADER, who)

    def _clear_junction(
        self, ego: EgoState, progress: float, actors: Actors, ahead: Corridor
    ) -> Demand:
        """Wait before a junction when there is no room behind the queue beyond it."""
        room = Demand(math.inf, Cause.JUNCTION)
        passage = self._next_passage(progress)
        if passage is None:
            return room
        distance = passage.entry - progress - HALF
        if distance > 30.0 or distance < -1.0:
            return room
        needed = passage.exit - progress + EGO_LENGTH + ROOM_BEYOND
        blocking = ahead.inside & ~ahead.crossing & (ahead.speeds < SLOW_LEADER)
        blocking &= actors.kinds != ActorKind.PEDESTRIAN  # they walk on
        # A slow leader is expected to go on for two seconds as it drives now.
        place = ahead.nearest + 2.0 * ahead.speeds
        blocking &= (place < needed) & (ahead.nearest > distance + HALF - 1.0)
        if not blocking.any():
            return room
        who = int(actors.ids[np.argmin(np.where(blocking, ahead.nearest, math.inf))])
        return Demand(stop_within(ego.speed, max(distance, 0.1)), Cause.JUNCTION, who)

    def _next_passage(self, progress: float) -> Passage | None:
        front = progress + HALF
        return next((item for item in self._passages if item.entry > front - 1.0), None)

    def _avoid(
        self,
        observation: Observation,
        route: RouteAhead,
        ahead: Corridor,
        least: Demand,
        target: float,
    ) -> Demand:
        """Lower a demand to the greatest acceleration that meets no forecast box."""
        ego, actors = observation.ego, observation.actors
        if actors is None:
            return least
        keep = np.flatnonzero(may_conflict(ego, actors, ahead))
        if not keep.size:
            self._waited = 0.0
            return least
        boldness = min(max((self._waited - PATIENCE) / SHRINKING, 0.0), 1.0)
        forecast = self._forecaster(observation, keep)
        first = np.array([least.pull])
        travel = rollout(ego.speed, first, np.array([target]))
        ours = first_conflicts(ego_poses(route, route.past, travel), forecast, boldness)
        if ours.times[0] == math.inf:
            self._waited = 0.0
            return least
        self._waited = self._waited + INTERVAL * TICK if ego.speed < 0.5 else 0.0
        choices = np.concatenate((first, CHOICES[least.pull > CHOICES]))
        travel = rollout(ego.speed, choices, np.full(len(choices), target))
        best = clearest(ego_poses(route, route.past, travel), forecast, boldness)
        pull = self._at_the_line(ego, route.progress, float(choices[best]), travel[best])
        if pull >= least.pull:
            return least
        return Demand(pull, Cause.CONFLICT, int(actors.ids[keep[ours.actors[0]]]))

    def _at_the_line(
        self, ego: EgoState, progress: float, pull: float, travel: np.ndarray
    ) -> float:
        """Rather stop at a junction's line than inside it."""
        passage = self._next_passage(progress)
        if passage is None:
            return pull
        distance = passage.entry - progress - HALF
        reached = progress + HALF + travel[-1]
        stops = travel[-1] - travel[-2] < STEP * CREEPING
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


def _reason(least: Demand, free: Demand) -> Reason:
    """Return the reason for a demand; who costs next to nothing is none."""
    if least.pull < free.pull - NOTICEABLE:
        return Reason(least.cause, least.actor)
    return Reason(Cause.LIMIT if free.pull < -NOTICEABLE else Cause.FREE)
