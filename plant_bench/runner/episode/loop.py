"""The episode loop: simulation, planner, controller and referee, tick by tick."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from plant_bench.agent import Control, Input, Observation
from plant_bench.agents.loading.registry import Loader, load_agent
from plant_bench.data.recorder import Recorder
from plant_bench.errors import AgentError
from plant_bench.runner.decisions import Decision, PlannerSession
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.outcome import Outcome
from plant_bench.runner.episode.timing import Stopwatch
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.referee import Referee, result_of
from plant_bench.scoring.results import Crash, EpisodeHeader, EpisodeResult, HazardRecord
from plant_bench.sim.simulation import Simulation
from plant_bench.world.route import Route, Scenario
from plant_bench.world.scene import Scene

PROGRESS_INTERVAL = 100  # ticks between two calls of the progress callback


@runtime_checkable
class Override(Protocol):
    """Replaces the agent's control at some ticks, for data collection."""

    def executed(
        self, scene: Scene, progress: float, offset: float, control: Control, /
    ) -> Control:
        """Return the control to execute.

        Args:
            scene: The current scene.
            progress: Distance driven along the route, metres.
            offset: Lateral distance of the ego from the route, metres, positive to the left.
            control: The agent's control.
        """
        ...


class Episode:
    """A running simulation and its referee; mutable, and a context manager that closes SUMO.

    The driver calls `advance` until the episode is over. Drivers are planners (`drive`), learners
    in reinforcement learning, and recorded controls.

    Attributes:
        simulation: The simulation.
        referee: Judges each scene.
        scene: The current scene.
        watch: Measures the time of each part.

    Args:
        scenario: The scenario to drive.
        self_driving: Let SUMO's driver model drive; controls then have no effect.
        watch: A stopwatch that was started earlier; None to start one now.

    Raises:
        InputError: The town or the density does not exist.
        SimulationError: SUMO fails.
    """

    def __init__(
        self, scenario: Scenario, *, self_driving: bool = False, watch: Stopwatch | None = None
    ) -> None:
        self.watch = watch or Stopwatch()
        self.route: Route = scenario.route
        self.simulation = Simulation(scenario, self_driving=self_driving)
        self.referee = Referee(self.simulation.town, self.route)
        self.scene = self.simulation.scene
        self.referee.judge(self.scene)

    def __enter__(self) -> "Episode":  # noqa: PYI034
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def over(self) -> bool:
        """Whether the referee has ended the episode."""
        return self.referee.status is not None

    def advance(self, control: Control) -> Scene:
        """Execute a control for one tick, judge the new scene and return it.

        Raises:
            SimulationError: SUMO has lost the ego.
        """
        watch = self.watch
        self.scene = scene = self.simulation.step(control)
        watch.lap("simulation")
        self.referee.judge(scene)
        watch.lap("referee")
        return scene

    def hazards(self) -> tuple[HazardRecord, ...]:
        """Return the current state of the route's hazards."""
        return tuple(
            HazardRecord.model_validate(outcome._asdict()) for outcome in self.simulation.outcomes
        )

    def result(self, header: EpisodeHeader, crash: Crash | None = None) -> EpisodeResult:
        """Return the record of the episode, which must be over or have crashed; see `result_of`."""
        return result_of(self.referee, header, crash=crash, hazards=self.hazards())

    def close(self) -> None:
        """Close SUMO; the process may then start another simulation."""
        self.simulation.close()


@dataclass(frozen=True, eq=False, slots=True)
class Step:
    """One tick of an episode that a planner drives.

    Attributes:
        scene: The scene before the control is executed.
        observation: The planner's observation; None at ticks without a decision.
        decision: The planner's decision; None at the same ticks.
        control: The control to execute at this tick.
        disturbed: Whether an override has changed the planner's control.
    """

    scene: Scene
    observation: Observation | None
    decision: Decision | None
    control: Control
    disturbed: bool


def drive(
    episode: Episode, planner: PlannerSession, override: Override | None = None
) -> Iterator[Step]:
    """Let a planner drive an episode until the referee ends it; yield before each tick.

    The tick is executed when the iterator is advanced.

    Raises:
        AgentError: The planner fails.
        SimulationError: SUMO has lost the ego.
    """
    referee, watch = episode.referee, episode.watch
    planner.start()
    control = Control(0.0, 0.0)
    watch.lap("start_up")
    while not episode.over:
        scene, observation, decision = episode.scene, None, None
        if planner.due(scene.tick):
            facts = episode.simulation.privileged() if planner.privileged else None
            watch.lap("privileged")
            observation = planner.observe(scene, referee.progress, referee.offset, facts)
            watch.lap("simulation")
            decision = planner.decide(scene, observation)
            watch.lap("agent")
            control = decision.control
        executed = control
        if override is not None:
            executed = override.executed(scene, referee.progress, referee.offset, control)
        yield Step(scene, observation, decision, executed, executed != control)
        episode.advance(executed)


def run_episode(
    job: Job,
    *,
    recording: Path | None = None,
    progress: Callable[[float], None] | None = None,
    thinning: int = 1,
    override: Override | None = None,
    load: Loader = load_agent,
) -> Outcome:
    """Drive one episode to its end.

    Args:
        job: The episode to drive.
        recording: Path of the recording; None to write none.
        progress: Called every `PROGRESS_INTERVAL` ticks with the fraction of the route completed.
        thinning: Interval of the ticks at which actors are recorded.
        override: Changes the executed control; for data collection, never for scores.
        load: Loads the planner.

    Raises:
        InputError: The agent, the town or the density does not exist.
        SimulationError: SUMO fails; this is not a failure of the agent.
    """
    watch = Stopwatch()
    agent = load(job.planner or job.agent)
    header = job.header(agent.inputs)
    metadata = header.model_dump(mode="json")
    recorder = None if recording is None else Recorder(recording, metadata, every=thinning)
    crash: Crash | None = None
    self_driving = Input.SIMULATOR in agent.inputs
    with Episode(job.scenario, self_driving=self_driving, watch=watch) as episode:
        try:
            for step in drive(episode, PlannerSession(agent, job.route, job.seed), override):
                _record_step(step, recorder)
                if progress is not None and step.scene.tick % PROGRESS_INTERVAL == 0:
                    progress(episode.referee.completion)
        except AgentError as error:
            crash = Crash(Status.AGENT_CRASHED, str(error))
        result = episode.result(header, crash)
    scene = episode.scene
    if recorder is not None:
        recorder.add(scene)
        hazards = [hazard.model_dump(mode="json") for hazard in result.hazards]
        recorder.close(hazards=hazards, **({} if crash is None else vars(crash)))
        watch.lap("recording")
    return Outcome(result, watch.timing(scene.time, scene.tick))


def _record_step(step: Step, recorder: Recorder | None) -> None:
    if recorder is None:
        return
    if step.decision is None:
        recorder.add(step.scene, disturbed=step.disturbed)
    else:
        action, reason = step.decision.action, step.decision.reason
        recorder.add(step.scene, action, reason, disturbed=step.disturbed)
