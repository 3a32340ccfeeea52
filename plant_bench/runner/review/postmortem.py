"""Postmortem of an episode: simulates it again and queries planner and expert in shadow mode.

The expert's actions in the scenes that the planner reached show what it would have done. The
planner is queried for its ranking, which is not recorded; its actions must equal the recorded ones,
else its code has changed and the ranking is dropped.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from plant_bench.agent import Agent, Control, Input, Plan, Privileged, Ranker, Reason
from plant_bench.agents.loading.registry import load_agent
from plant_bench.data.recording import Recording
from plant_bench.errors import AgentError, InputError
from plant_bench.runner.decisions import Decision, PlannerSession, same_action
from plant_bench.runner.review.actor_ranking import rank_actors
from plant_bench.runner.review.resimulation import Tick, simulate_again
from plant_bench.runner.review.review_frames import Moment, Postmortem, Window
from plant_bench.scoring.results import EpisodeResult
from plant_bench.sensing.inputs import PERCEIVED
from plant_bench.sensing.observe import Sensors
from plant_bench.user_code import contained
from plant_bench.world.route import Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import TICK, EgoState, Scene

PROGRESS_INTERVAL = 100  # ticks between two calls of the progress callback


def review_episode(
    recording: Recording,
    result: EpisodeResult,
    route: Route,
    windows: Sequence[Window],
    progress: Callable[[float], None] | None = None,
) -> Postmortem:
    """Simulate an episode again and return the moments in given windows.

    Args:
        recording: Recording of every tick.
        result: The episode's record.
        route: The route it was driven on.
        windows: Time windows of interest; the simulation ends with the last of them.
        progress: Called repeatedly with the fraction of the work done, 0 to 1.

    Raises:
        InputError: The recording is thinned, or the route has changed.
        SimulationError: SUMO fails.
    """
    until = max((window.last for window in windows), default=0)
    with contained():
        review = _Review(recording, result, route, windows)
        for tick in simulate_again(recording, result, route, until=until):
            review.process(tick)
            if progress is not None and tick.row % PROGRESS_INTERVAL == 0:
                progress(tick.row / max(until, 1))
    return review.postmortem()


class _ShadowAgent:
    """A planner in shadow mode, which is disabled when it fails or no longer applies; mutable.

    Attributes:
        note: Why it was disabled; empty if it is not.
        last: Its last decision.
        session: The planner's session; None if it is disabled.
    """

    def __init__(self, agent: Agent | None, route: Route, seed: int, note: str = "") -> None:
        self.note = note
        self.last: Decision | None = None
        self.session: PlannerSession | None = None
        if agent is not None:
            try:
                self.session = PlannerSession(agent, route, seed)
                self.session.start()
            except AgentError as error:
                self.disable(str(error))

    def disable(self, reason: str) -> None:
        """Stop querying the planner."""
        self.note, self.last, self.session = reason, None, None

    def query(
        self, scene: Scene, position: RouteProgress, facts: Privileged | None, *, ranking: bool
    ) -> None:
        """Query the planner's decision; an `AgentError` disables it."""
        if self.session is None:
            return
        try:
            observation = self.session.observe(scene, position.progress, position.offset, facts)
            ranks = rank_actors(self.session.agent, observation) if ranking else None
            self.last = replace(self.session.decide(scene, observation), ranking=ranks)
        except AgentError as error:
            self.disable(f"it failed when queried at {scene.time:.1f} s: {error}")


class _Review:
    """Queries the planners and collects moments, tick by tick; mutable."""

    def __init__(
        self,
        recording: Recording,
        result: EpisodeResult,
        route: Route,
        windows: Sequence[Window],
    ) -> None:
        self._result, self._route, self._windows = result, route, windows
        self._actions, self._reasons = recording.actions, recording.reasons
        self._reason: Reason | None = None
        self._position = RouteProgress(route)
        self._sensors = Sensors(route, result.seed, PERCEIVED)
        self._expert = _ShadowAgent(load_agent("expert"), route, result.seed)
        self._planner = _ShadowAgent(*_planner_of(result, route))
        session = self._planner.session
        self._ranked_itself = session is not None and isinstance(session.agent, Ranker)
        self._plan: Plan | None = None
        self._planned_at: EgoState = recording[0].ego
        self._difference, self._differs_at = "", None
        self._ticks = 0
        self._moments: dict[int, Moment] = {}

    def process(self, tick: Tick) -> None:
        """Process the next tick."""
        scene = tick.recorded
        self._position.follow(scene.ego.x, scene.ego.y)
        self._ticks += 1
        if tick.difference and self._differs_at is None:
            self._difference, self._differs_at = tick.difference, scene.tick
            self._disable_privileged()
        if tick.decided:
            action = self._actions[tick.row]
            self._plan = action if isinstance(action, Plan) else None
            self._planned_at = scene.ego
            self._reason = self._reasons[tick.row]
        if tick.row < len(self._actions) - 1:  # no decision is made at the last scene
            self._query(tick)
        if any(scene.tick in window for window in self._windows):
            self._moments[scene.tick] = self._moment(scene, tick.control)

    def postmortem(self) -> Postmortem:
        """Return the collected data."""
        return Postmortem(
            result=self._result,
            route=self._route,
            moments=self._moments,
            ticks=self._ticks,
            difference=self._difference,
            differs_at=self._differs_at,
            planner_note=self._planner.note,
            ranked_itself=self._ranked_itself,
            expert_note=self._expert.note,
        )

    def _disable_privileged(self) -> None:
        """Disable planners with privileged inputs, since the recording has none."""
        for shadow in (self._expert, self._planner):
            if shadow.session is not None and shadow.session.privileged:
                shadow.disable(f"the simulation differs from the recording: {self._difference}")

    def _query(self, tick: Tick) -> None:
        scene, expert, planner = tick.recorded, self._expert, self._planner
        due = [item for item in (expert, planner) if item.session and item.session.due(scene.tick)]
        if planner.session is not None and tick.decided != (planner in due):
            planner.disable(_changed_code_note(scene))
            due = [item for item in due if item is not planner]
        if any(item.session is not None and item.session.privileged for item in due):
            facts = tick.facts()
        else:
            facts = None
        ranking = any(window.ranked_from <= scene.tick <= window.last for window in self._windows)
        for item in due:
            item.query(scene, self._position, facts, ranking=ranking and item is planner)
        decision = planner.last if planner in due else None
        if decision is not None and not same_action(decision, self._actions[tick.row]):
            planner.disable(_changed_code_note(scene))

    def _moment(self, scene: Scene, control: Control) -> Moment:
        position = self._position
        return Moment(
            scene=scene,
            seen=self._sensors.observe(scene, position.progress, position.offset),
            control=control,
            plan=self._plan,
            planned_at=self._planned_at,
            planner=self._planner.last,
            expert=self._expert.last,
            reason=self._reason,
        )


def _planner_of(result: EpisodeResult, route: Route) -> tuple[Agent | None, Route, int, str]:
    """Return the arguments of `_ShadowAgent` for the planner that drove."""
    if Input.SIMULATOR.value in result.inputs:
        return None, route, result.seed, "SUMO's driver model drove, which cannot be queried"
    try:
        return load_agent(result.agent), route, result.seed, ""
    except InputError as error:
        return None, route, result.seed, str(error)


def _changed_code_note(scene: Scene) -> str:
    time = round(scene.tick * TICK, 2)
    return f"at {time} s its action differs from the recorded one, so its code has changed"
