"""The careful driver: the algorithm shared by the expert and the rule-based planners.

They differ only in the forecast. The acceleration is the lowest of those allowed by the speed
limit, the leader, the traffic light, a junction that cannot be cleared, and the predicted
conflicts; the steering follows the route.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from plant_bench.agent import (
    NO_ACTOR,
    Cause,
    Control,
    Observation,
    Reason,
    RouteAhead,
)
from plant_bench.agents.careful.actor_filter import (
    may_conflict,
    stationary_contacts,
    yielding_followers,
)
from plant_bench.agents.careful.conflicts import best_choice, first_conflicts
from plant_bench.agents.careful.forecast import Forecast
from plant_bench.agents.careful.leader import Corridor, corridor
from plant_bench.agents.careful.reduced_pace import reduced_travel
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
RESTING_INTERVAL = 4  # ticks, while the ego is stationary and stays so: as for SUMO's drivers
CHOICES = np.array([0.5, 0.0, -1.0, -2.0, -3.5, -5.0, -8.0])  # m/s2, if the first choice conflicts
LINE_BRAKING = 4.5  # m/s2; up to this, stop at a junction's stop line for a conflict inside it
SLOW_LEADER = 3.0  # m/s below which a leader may block a junction
LEADER_GAP = 2.0  # m to a stationary leader, in the ego's reduced-pace rollout
EXIT_GAP = 1.5  # m kept free behind the ego when it has cleared a junction
PATIENCE = 8.0  # s of waiting after which the margins from stationary actors start to shrink
SHRINKING = 20.0  # s of further waiting until these margins are zero
CREEPING = 3.0  # m/s below which the ego counts as stopping inside a junction
STILL = 0.01  # m/s below which the ego is stationary
NOTICEABLE = 0.1  # m/s2 by which a demand must lower the acceleration to be a reason
HALF = 0.5 * EGO_LENGTH


class Demand(NamedTuple):
    """The acceleration limit of one driving rule.

    Attributes:
        acceleration: The highest acceleration that it allows, m/s2.
        cause: The rule.
        actor: The id of the actor that causes it, or `NO_ACTOR`.
    """

    acceleration: float
    cause: Cause
    actor: int = NO_ACTOR


class CarefulDriver:
    """Follows the route and keeps clear of forecast actors; mutable.

    Args:
        forecaster: Predicts the motion of the other actors.

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
            AgentError: `route` is None.
        """
        if route is None:
            message = "This driver needs the input 'route'."
            raise AgentError(message)
        self._passages = route.passages
        self._waited = 0.0
        self._reason = Reason(Cause.FREE)
        self.interval = INTERVAL

    def act(self, observation: Observation, max_acceleration: float = math.inf) -> Control:
        """Return the control.

        Args:
            observation: The observation.
            max_acceleration: Upper limit of the acceleration, m/s2, such as another planner's.

        Raises:
            AgentError: An input is missing.
        """
        route = observation.route
        if route is None or observation.actors is None:
            message = "This driver needs the inputs 'objects' and 'route'."
            raise AgentError(message)
        ego, actors = observation.ego, observation.actors
        if (contacts := stationary_contacts(ego, actors)).any():
            observation = observation.showing(~contacts)
        target = allowed_speed(route)
        free = Demand(min(idm(ego.speed, target), max_acceleration), Cause.LIMIT)
        least = self._decide(observation, route, free, target)
        self._reason = _reason(least, free)
        rests = ego.speed < STILL and least.acceleration <= 0.0
        self.interval = RESTING_INTERVAL if rests else INTERVAL
        return Control(least.acceleration, follow_route(observation.ego, route))

    def explain(self) -> Reason:
        """Return the reason for the last acceleration: the demand that was the lowest."""
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
        acceleration = idm(ego.speed, target, leader.distance - HALF, leader.speed)
        actor = NO_ACTOR if leader.actor < 0 else int(actors.ids[leader.actor])
        return Demand(acceleration, Cause.LEADER, actor)

    def _clear_junction(
        self, ego: EgoState, progress: float, actors: Actors, ahead: Corridor
    ) -> Demand:
        """Wait before a junction while the queue behind it leaves no space for the ego."""
        no_demand = Demand(math.inf, Cause.JUNCTION)
        passage = self._next_passage(progress)
        if passage is None:
            return no_demand
        distance = passage.entry - progress - HALF
        if distance > 30.0 or distance < -1.0:
            return no_demand
        needed = passage.exit - progress + EGO_LENGTH + EXIT_GAP
        blocking = ahead.inside & ~ahead.crossing & (ahead.speeds < SLOW_LEADER)
        blocking &= actors.kinds != ActorKind.PEDESTRIAN  # they walk on
        # A slow leader is assumed to keep its speed for two seconds.
        place = ahead.nearest + 2.0 * ahead.speeds
        blocking &= (place < needed) & (ahead.nearest > distance + HALF - 1.0)
        if not blocking.any():
            return no_demand
        actor = int(actors.ids[np.argmin(np.where(blocking, ahead.nearest, math.inf))])
        return Demand(stop_within(ego.speed, max(distance, 0.1)), Cause.JUNCTION, actor)

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
        """Lower a demand to the highest acceleration that overlaps no forecast box."""
        ego, actors = observation.ego, observation.actors
        if actors is None or (ego.speed < STILL and least.acceleration <= 0.0):
            return least  # stationary and staying so: a conflict could not lower it further
        keep = may_conflict(ego, actors, ahead).nonzero()[0]
        if not keep.size:
            self._waited = 0.0
            return least
        margin_reduction = min(max((self._waited - PATIENCE) / SHRINKING, 0.0), 1.0)
        forecast = self._forecaster(observation, keep)
        leader = ahead.leader()
        gap = leader.distance - HALF - LEADER_GAP
        choices = np.concatenate(([least.acceleration], CHOICES[least.acceleration > CHOICES]))
        travel = rollout(ego.speed, choices, target)
        slow = reduced_travel(travel[0], ego.speed, route, gap, leader.speed)
        continuing = ego_poses(route, np.stack((travel[0], slow)))
        row = _first_conflict(continuing, forecast, margin_reduction)
        if row >= 0 and (behind := yielding_followers(ego, actors.only(keep), forecast)).any():
            keep, forecast = keep[~behind], forecast.only(~behind)
            row = _first_conflict(continuing, forecast, margin_reduction)
        if row < 0:
            self._waited = 0.0
            return least
        self._waited = self._waited + self.interval * TICK if ego.speed < 0.5 else 0.0
        best = best_choice(ego_poses(route, travel), forecast, margin_reduction)
        acceleration = self._stop_at_line(ego, route.progress, float(choices[best]), travel[best])
        if acceleration >= least.acceleration:
            return least
        return Demand(acceleration, Cause.CONFLICT, int(actors.ids[keep[row]]))

    def _stop_at_line(
        self, ego: EgoState, progress: float, acceleration: float, travel: np.ndarray
    ) -> float:
        """Lower an acceleration that would stop inside a junction to one that stops at its line."""
        passage = self._next_passage(progress)
        if passage is None:
            return acceleration
        distance = passage.entry - progress - HALF
        reached = progress + HALF + travel[-1]
        stops = travel[-1] - travel[-2] < STEP * CREEPING
        inside = passage.entry < reached < passage.exit + EGO_LENGTH
        needed = ego.speed**2 / (2.0 * max(distance, 0.1))
        if stops and inside and distance > -0.5 and needed < LINE_BRAKING:
            return min(acceleration, stop_within(ego.speed, max(distance, 0.1)))
        return acceleration


def _first_conflict(poses: np.ndarray, forecast: Forecast, margin_reduction: float) -> int:
    """Return the forecast row of the earliest conflict over all rollouts; -1 for none."""
    conflicts = first_conflicts(poses, forecast, margin_reduction)
    return int(conflicts.actors[np.argmin(conflicts.times)])


def _reason(least: Demand, free: Demand) -> Reason:
    """Return the reason for a demand; one that is hardly lower than `free` is no reason."""
    if least.acceleration < free.acceleration - NOTICEABLE:
        return Reason(least.cause, least.actor)
    return Reason(Cause.LIMIT if free.acceleration < -NOTICEABLE else Cause.FREE)
