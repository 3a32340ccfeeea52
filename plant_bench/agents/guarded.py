"""A planner with a guard: a careful driver brakes for it where it would have to brake hard.

Planners that lead CARLA's leaderboard have such a layer between their network and the pedals
(InterFuser's safety controller, for instance). It sees what the planner may see and nothing else.
"""

from plant_bench.agent import Agent, Cause, Control, Input, Observation, Plan, Reason
from plant_bench.agent_check import decision_interval, reason_of
from plant_bench.agents.careful.driver import STILL
from plant_bench.agents.rule_based_tracks import RuleBasedTracks
from plant_bench.controller import control_of
from plant_bench.features.motion import MotionTracker
from plant_bench.sensing.inputs import PERCEIVED, given
from plant_bench.world.route import Route
from plant_bench.world.scene import TICK

EMERGENCY = -2.0  # m/s2; whatever braking is gentler is left to the planner
RASH = 1.0  # m/s2 of acceleration that is not to lead into a conflict
CALM = -0.5  # m/s2 of the guard's own demand above which it looks again after
CALM_TIME = 0.2  # s
HALF_TICK = 0.5 * TICK


class Guarded:
    """Drives as another planner would, but brakes where a careful driver would brake hard.

    The guard only ever takes speed away: it neither steers nor accelerates. It tells its reason
    when it brakes.

    Args:
        planner: Who drives.
        tracks: What remembers who was where, where the planner does so itself.
    """

    def __init__(self, planner: Agent, tracks: MotionTracker | None = None) -> None:
        self._planner = planner
        self._guard = RuleBasedTracks(tracks)
        self._reason: Reason | None = None
        self._calm_until = 0.0
        self.inputs = planner.inputs | PERCEIVED

    @property
    def interval(self) -> int:
        """Ticks until the next decision."""
        return decision_interval(self._planner)

    def reset(self, route: Route | None) -> None:
        """Start a new episode."""
        self._planner.reset(route if Input.ROUTE in self._planner.inputs else None)
        self._guard.reset(route)
        self._reason = None
        self._calm_until = 0.0

    def act(self, observation: Observation) -> Plan | Control:
        """Let the planner decide, and brake instead where that is too fast."""
        action = self._planner.act(given(observation, self._planner.inputs))
        self._guard.watch(observation)
        control = control_of(action, observation.ego)
        stays = observation.ego.speed < STILL and control.acceleration <= 0.0
        if not stays and observation.time >= self._calm_until:
            wish = control.acceleration
            careful = self._guard.act(observation, wish).acceleration
            reason = self._guard.explain()
            rash = reason.cause is Cause.CONFLICT and careful < wish - RASH
            if careful < min(wish, EMERGENCY) or (rash and wish > RASH):
                self._reason = reason
                return Control(careful, control.steering)
            if careful > CALM:
                self._calm_until = observation.time + CALM_TIME - HALF_TICK
        self._reason = reason_of(self._planner)
        return action

    def explain(self) -> Reason | None:
        """Return why the guard brakes; where it does not, what the planner says."""
        return self._reason
