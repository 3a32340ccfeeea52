"""One episode: the one loop in which everything meets."""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol, runtime_checkable

from plant_bench.agent import Agent, Control, Input, Observation, Plan, Reason
from plant_bench.agent_check import check_action, decision_interval, reason_of
from plant_bench.agents.loading.registry import load_agent
from plant_bench.controller import control_of
from plant_bench.data.recorder import Recorder
from plant_bench.errors import AgentError
from plant_bench.runner.asking import asked
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.outcome import Episode
from plant_bench.runner.episode.timing import Stopwatch
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.referee import Referee, result_of
from plant_bench.scoring.results import Crash, HazardRecord
from plant_bench.sensing.observe import observe
from plant_bench.sim.simulation import Simulation
from plant_bench.world.route import Route
from plant_bench.world.scene import Scene

PROGRESS_INTERVAL = 100  # ticks between two calls of the progress callback


@runtime_checkable
class Override(Protocol):
    """Executes something else than the agent's control now and then, to collect data."""

    def executed(
        self, scene: Scene, progress: float, offset: float, control: Control, /
    ) -> Control:
        """Return what is executed.

        Args:
            scene: Where the ego is.
            progress: Metres of the route that it has driven.
            offset: Its lateral distance from the route, metres, positive to the left.
            control: What the agent asks for.
        """
        ...


def run_episode(
    job: Job,
    *,
    recording: Path | None = None,
    progress: Callable[[float], None] | None = None,
    thinning: int = 1,
    override: Override | None = None,
) -> Episode:
    """Drive one episode to its end.

    Args:
        job: What to drive.
        recording: Where to write every tick, if anywhere.
        progress: Told the share of the route driven, now and then.
        thinning: Record the actors at every so many ticks alone.
        override: Changes what is executed; for collecting data, never for scores.

    Raises:
        InputError: The agent, the town or the density does not exist.
        SimulationError: SUMO fails; the episode says nothing about the agent then.
    """
    watch = Stopwatch()
    agent = load_agent(job.agent)
    header = job.header(agent.inputs)
    about = header.model_dump(mode="json")
    recorder = None if recording is None else Recorder(recording, about, every=thinning)
    crash: Crash | None = None
    self_driving = Input.SIMULATOR in agent.inputs
    with Simulation(job.scenario, self_driving=self_driving) as simulation:
        referee = Referee(simulation.town, job.route)
        try:
            _drive(agent, simulation, referee, job.route, recorder, watch, progress, override)
        except AgentError as error:
            crash = Crash(Status.AGENT_CRASHED, str(error))
        scene = simulation.scene
        hazards = tuple(
            HazardRecord.model_validate(outcome._asdict()) for outcome in simulation.outcomes
        )
    if recorder is not None:
        recorder.add(scene)
        told = [hazard.model_dump(mode="json") for hazard in hazards]
        recorder.close(hazards=told, **({} if crash is None else vars(crash)))
        watch.lap("recording")
    result = result_of(referee, header, crash=crash, hazards=hazards)
    return Episode(result, watch.timing(scene.time, scene.tick))


def _drive(
    agent: Agent,
    simulation: Simulation,
    referee: Referee,
    route: Route,
    recorder: Recorder | None,
    watch: Stopwatch,
    progress: Callable[[float], None] | None,
    override: Override | None,
) -> None:
    """Drive until the referee ends the episode, or the agent fails."""
    inputs = agent.inputs
    privileged = Input.PRIVILEGED in inputs
    scene = simulation.scene
    referee.judge(scene)
    asked("reset", agent.reset, route.plan if Input.ROUTE in inputs else None)
    control, due = Control(0.0, 0.0), 0
    watch.lap("start_up")
    while referee.status is None:
        action: Plan | Control | None = None
        reason: Reason | None = None
        if scene.tick == due:
            facts = simulation.privileged() if privileged else None
            watch.lap("privileged")
            observation = observe(scene, route, referee.progress, referee.offset, inputs, facts)
            watch.lap("simulation")
            action, reason = _act(agent, observation)
            due += decision_interval(agent)
            watch.lap("agent")
            control = control_of(action, scene.ego)
        executed = control
        if override is not None:
            executed = override.executed(scene, referee.progress, referee.offset, control)
        if recorder is not None:
            recorder.add(scene, action, reason, disturbed=executed != control)
        scene = simulation.step(executed)
        watch.lap("simulation")
        referee.judge(scene)
        watch.lap("referee")
        if progress is not None and scene.tick % PROGRESS_INTERVAL == 0:
            progress(referee.completion)


def _act(agent: Agent, observation: Observation) -> tuple[Plan | Control, Reason | None]:
    """Return what the agent answers, and why if it tells."""
    action = asked("act", agent.act, observation)
    try:
        reason = reason_of(agent)
    except AgentError:
        raise
    except (Exception, SystemExit) as error:
        message = f"explain raised {type(error).__name__}: {error}"
        raise AgentError(message) from error
    return check_action(action), reason
