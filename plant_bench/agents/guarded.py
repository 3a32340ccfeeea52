"""Adds a safety layer to any planner: brakes where the rule-based careful driver brakes hard.

Planners at the top of CARLA's leaderboard have such a layer between network and actuators
(InterFuser's safety controller, for instance). It uses no privileged inputs.
"""

from plant_bench.agent import Agent, Cause, Control, Input, Observation, Plan, Reason
from plant_bench.agent_check import decision_interval, reason_of
from plant_bench.agents.careful.driver import STILL
from plant_bench.agents.rule_based_tracks import RuleBasedTracks
from plant_bench.controller import control_of
from plant_bench.features.motion import MotionTracker
from plant_bench.sensing.inputs import PERCEIVED, restrict
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK

EMERGENCY = -2.0  # m/s2; gentler braking is left to the planner
EXCESS = 1.0  # m/s2; accelerating by more than this into a conflict is overridden
NO_DEMAND = -0.5  # m/s2; above this acceleration, the safety layer is skipped for
SKIP_TIME = 0.2  # s
HALF_TICK = 0.5 * TICK


class Guarded:
    """Drives as the planner does, but brakes where the careful driver would brake hard.

    The safety layer only reduces the acceleration; it never steers. When it brakes, `explain`
    returns its reason.

    Args:
        planner: The planner.
        tracker: The planner's motion tracker, which the safety layer shares; None if it has none.
    """

    def __init__(self, planner: Agent, tracker: MotionTracker | None = None) -> None:
        self._planner = planner
        self._safety = RuleBasedTracks(tracker)
        self._reason: Reason | None = None
        self._skip_until = 0.0
        self.inputs = planner.inputs | PERCEIVED

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return decision_interval(self._planner)

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._planner.reset(route if Input.ROUTE in self._planner.inputs else None)
        self._safety.reset(route)
        self._reason = None
        self._skip_until = 0.0

    def act(self, observation: Observation) -> Plan | Control:
        """Return the planner's action, or a braking control if the safety layer intervenes."""
        action = self._planner.act(restrict(observation, self._planner.inputs))
        self._safety.update(observation)
        control = control_of(action, observation.ego)
        stays = observation.ego.speed < STILL and control.acceleration <= 0.0
        if not stays and observation.time >= self._skip_until:
            planned = control.acceleration
            careful = self._safety.act(observation, planned).acceleration
            reason = self._safety.explain()
            conflict = reason.cause is Cause.CONFLICT and careful < planned - EXCESS
            if careful < min(planned, EMERGENCY) or (conflict and planned > EXCESS):
                self._reason = reason
                return Control(careful, control.steering)
            if careful > NO_DEMAND:
                self._skip_until = observation.time + SKIP_TIME - HALF_TICK
        self._reason = reason_of(self._planner)
        return action

    def explain(self) -> Reason | None:
        """Return the safety layer's reason if it brakes, else the planner's."""
        return self._reason
