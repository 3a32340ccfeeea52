"""Postmortem of an episode: simulates it again and queries planner and expert in shadow mode.

The expert's actions in the scenes that the planner reached show what it would have done. The
planner is queried for its ranking, which is not recorded; its actions must equal the recorded ones,
else its code has changed and the ranking is dropped.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from plant_bench.agent import Agent, Control, Input, Plan, Privileged, Ranker
from plant_bench.agents.loading.registry import load_agent
from plant_bench.data.recording import Recording
from plant_bench.errors import AgentError, InputError
from plant_bench.runner.decisions import Decision, PlannerSession, same_action
from plant_bench.runner.review.actor_ranking import ranking_before
from plant_bench.runner.review.resimulation import Tick, simulate_again
from plant_bench.runner.review.review_frames import Moment, Postmortem, Window
from plant_bench.scoring.results import EpisodeResult
from plant_bench.sensing.inputs import PERCEIVED
from plant_bench.sensing.observe import Sensors
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
    """Simulate an episode again and keep the moments of some windows.

    Args:
        recording: Of every tick.
        result: The episode's record.
        route: The route it was driven on.
        windows: To be looked at; the simulation ends with the last of them.
        progress: Told the share that is done, now and then.

    Raises:
        InputError: The recording is thinned, or the route is not what it was.
        SimulationError: SUMO fails.
    """
    look = _Look(recording, result, route, windows)
    until = max((window.last for window in windows), default=0)
    for tick in simulate_again(recording, result, route, until=until):
        look.at(tick)
        if progress is not None and tick.row % PROGRESS_INTERVAL == 0:
            progress(tick.row / max(until, 1))
    return look.postmortem()


class _ShadowAgent:
    """A shadow that may drop out; mutable.

    Attributes:
        note: Why it has dropped out; empty while it has not.
        last: Its last answer.
        shadow: Who is asked; None after it has dropped out.
    """

    def __init__(self, agent: Agent | None, route: Route, seed: int, note: str = "") -> None:
        self.note = note
        self.last: Decision | None = None
        self.shadow: PlannerSession | None = None
        if agent is not None:
            try:
                self.shadow = PlannerSession(agent, route, seed)
                self.shadow.start()
            except AgentError as error:
                self.drop(str(error))

    def drop(self, why: str) -> None:
        """Ask it no more."""
        self.note, self.last, self.shadow = why, None, None

    def ask(
        self, scene: Scene, place: RouteProgress, facts: Privileged | None, *, ranking: bool
    ) -> None:
        """Ask it, which may make it drop out."""
        if self.shadow is None:
            return
        try:
            seen = self.shadow.observe(scene, place.progress, place.offset, facts)
            ranks = ranking_before(self.shadow.agent, seen) if ranking else None
            self.last = replace(self.shadow.decide(scene, seen), ranking=ranks)
        except AgentError as error:
            self.drop(f"asked again at {scene.time:.1f} s, it failed: {error}")


class _Look:
    """Goes through the ticks of one episode; mutable."""

    def __init__(
        self,
        recording: Recording,
        result: EpisodeResult,
        route: Route,
        windows: Sequence[Window],
    ) -> None:
        self._result, self._route, self._windows = result, route, windows
        self._actions = recording.actions
        self._place = RouteProgress(route)
        self._sensors = Sensors(route, result.seed, PERCEIVED)
        self._expert = _ShadowAgent(load_agent("expert"), route, result.seed)
        self._planner = _ShadowAgent(*_planner_of(result, route))
        shadow = self._planner.shadow
        self._ranked_itself = shadow is not None and isinstance(shadow.agent, Ranker)
        self._plan: Plan | None = None
        self._planned_at: EgoState = recording[0].ego
        self._difference, self._differs_at = "", None
        self._ticks = 0
        self._moments: dict[int, Moment] = {}

    def at(self, tick: Tick) -> None:
        """Look at the next tick."""
        scene = tick.recorded
        self._place.follow(scene.ego.x, scene.ego.y)
        self._ticks += 1
        if tick.difference and self._differs_at is None:
            self._difference, self._differs_at = tick.difference, scene.tick
            self._without_facts()
        if tick.decided:
            action = self._actions[tick.row]
            self._plan = action if isinstance(action, Plan) else None
            self._planned_at = scene.ego
        if tick.row < len(self._actions) - 1:  # nobody is asked at the last scene of an episode
            self._ask(tick)
        if any(scene.tick in window for window in self._windows):
            self._moments[scene.tick] = self._moment(scene, tick.control)

    def postmortem(self) -> Postmortem:
        """Return all that was seen."""
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

    def _without_facts(self) -> None:
        """Drop who needs privileged facts, since there are none for the recorded scenes now."""
        for shadow in (self._expert, self._planner):
            if shadow.shadow is not None and shadow.shadow.privileged:
                shadow.drop(f"simulated again, {self._difference} differ from what was recorded")

    def _ask(self, tick: Tick) -> None:
        scene, expert, planner = tick.recorded, self._expert, self._planner
        asks = [item for item in (expert, planner) if item.shadow and item.shadow.due(scene.tick)]
        if planner.shadow is not None and tick.decided != (planner in asks):
            planner.drop(_otherwise(scene))
            asks = [item for item in asks if item is not planner]
        if any(item.shadow is not None and item.shadow.privileged for item in asks):
            facts = tick.facts()
        else:
            facts = None
        ranking = any(window.ranked_from <= scene.tick <= window.last for window in self._windows)
        for item in asks:
            item.ask(scene, self._place, facts, ranking=ranking and item is planner)
        asked = planner.last if planner in asks else None
        if asked is not None and not same_action(asked, self._actions[tick.row]):
            planner.drop(_otherwise(scene))

    def _moment(self, scene: Scene, control: Control) -> Moment:
        place = self._place
        return Moment(
            scene=scene,
            seen=self._sensors.observe(scene, place.progress, place.offset),
            control=control,
            plan=self._plan,
            planned_at=self._planned_at,
            planner=self._planner.last,
            expert=self._expert.last,
        )


def _planner_of(result: EpisodeResult, route: Route) -> tuple[Agent | None, Route, int, str]:
    """Return the planner that drove, as far as it can be asked again, or why not."""
    if Input.SIMULATOR.value in result.inputs:
        return None, route, result.seed, "SUMO's own driver drove, who cannot be asked"
    try:
        return load_agent(result.agent), route, result.seed, ""
    except InputError as error:
        return None, route, result.seed, str(error)


def _otherwise(scene: Scene) -> str:
    when = round(scene.tick * TICK, 2)
    return f"asked again, it answers otherwise than recorded (at {when} s): its code has changed"
