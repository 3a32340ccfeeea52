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
    Observation,
    Reason,
    RouteAhead,
)
from plant_bench.agents.careful.actor_filter import brake_for_ego, left_behind, may_conflict
from plant_bench.agents.careful.conflicts import clearest, first_conflicts
from plant_bench.agents.careful.forecast import Forecast
from plant_bench.agents.careful.leader import Corridor, corridor
from plant_bench.agents.careful.reduced_pace import at_slower_pace
from plant_bench.agents.idm import idm, light_limit, stop_within
from plant_bench.controller import follow_route
from plant_bench.errors import AgentError
from plant_bench.features.limits import allowed_speed
from plant_bench.features.rollouts import STEP, ego_poses, rollout
from plant_bench.world.route import Passage, Route
from plant_bench.world.scene import (
    EGO_LENGTH,
    TICK,
    ActorKind,
    Actors,
    EgoState,
)

Forecaster = Callable[[Observation, np.ndarray], Forecast]

INTERVAL = 2  # ticks between two decisions: 10 Hz
RESTING_INTERVAL = 4  # ticks, while it stands and has no reason to go: as SUMO's drivers
CHOICES = np.array([0.5, 0.0, -1.0, -2.0, -3.5, -5.0, -8.0])  # m/s2 tried when the first fails
LINE_BRAKING = 4.5  # m/s2 up to which a conflict in a junction is answered at its stop line
SLOW_LEADER = 3.0  # m/s below which a leader may block a junction
LEADER_GAP = 2.0  # m to a standing leader, in the slower forecast of the ego itself
ROOM_BEYOND = 1.5  # m kept free behind the ego when it has cleared a junction
PATIENCE = 8.0  # s of waiting after which the margins towards who stands begin to shrink
SHRINKING = 20.0  # s of further waiting until they are gone
CREEPING = 3.0  # m/s below which a junction is not left in good time
STILL = 0.01  # m/s, below which the ego stands
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

    Attributes:
        interval: Ticks until the next decision.
    """

    def __init__(self, forecaster: Forecaster) -> None:
        self._forecaster = forecaster
        self._passages: tuple[Passage, ...] = ()
        self._waited = 0.0
        self._reason = Reason(Cause.FREE)
        self.interval = INTERVAL

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
        self.interval = INTERVAL

    def act(self, observation: Observation, wish: float = math.inf) -> Control:
        """Decide.

        Args:
            observation: What there is.
            wish: Acceleration not to be exceeded, m/s2: what somebody else is about to do.

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
        free = Demand(min(idm(ego.speed, target), wish), Cause.LIMIT)
        least = self._decide(observation, route, free, target)
        self._reason = _reason(least, free)
        rests = ego.speed < STILL and least.pull <= 0.0
        self.interval = RESTING_INTERVAL if rests else INTERVAL
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
        if actors is None or (ego.speed < STILL and least.pull <= 0.0):
            return least  # it stands and stays: nothing could hold it back more
        keep = may_conflict(ego, actors, ahead).nonzero()[0]
        if not keep.size:
            self._waited = 0.0
            return least
        boldness = min(max((self._waited - PATIENCE) / SHRINKING, 0.0), 1.0)
        forecast = self._forecaster(observation, keep)
        leader = ahead.leader()
        room = leader.distance - HALF - LEADER_GAP
        choices = np.concatenate(([least.pull], CHOICES[least.pull > CHOICES]))
        travel = rollout(ego.speed, choices, target)
        slow = at_slower_pace(travel[0], ego.speed, route, room, leader.speed)
        going_on = ego_poses(route, np.stack((travel[0], slow)))
        who = _first_met(going_on, forecast, boldness)
        if who != NOBODY and (behind := brake_for_ego(ego, actors.only(keep), forecast)).any():
            keep, forecast = keep[~behind], forecast.only(~behind)
            who = _first_met(going_on, forecast, boldness)
        if who == NOBODY:
            self._waited = 0.0
            return least
        self._waited = self._waited + self.interval * TICK if ego.speed < 0.5 else 0.0
        best = clearest(ego_poses(route, travel), forecast, boldness)
        pull = self._at_the_line(ego, route.progress, float(choices[best]), travel[best])
        if pull >= least.pull:
            return least
        return Demand(pull, Cause.CONFLICT, int(actors.ids[keep[who]]))

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


def _first_met(poses: np.ndarray, forecast: Forecast, boldness: float) -> int:
    """Return whose forecast box the ego meets first, at any pace: a row, `NOBODY` for none."""
    met = first_conflicts(poses, forecast, boldness)
    return int(met.actors[np.argmin(met.times)])


def _reason(least: Demand, free: Demand) -> Reason:
    """Return the reason for a demand; who costs next to nothing is none."""
    if least.pull < free.pull - NOTICEABLE:
        return Reason(least.cause, least.actor)
    return Reason(Cause.LIMIT if free.pull < -NOTICEABLE else Cause.FREE)
